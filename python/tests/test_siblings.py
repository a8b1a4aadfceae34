"""Which craft differ from their siblings: on fleets whose truth is known."""

import numpy as np
import pytest

pa = pytest.importorskip("pyarrow")

from pitchid import fleet  # noqa: E402

SIZES = {"dM_du": (23.0, 0.6, 0.3, 0.4), "trim": (0.01, 0.004, 0.002, 0.003)}
"""Mean, from craft to craft, from flight to flight, error of an estimate."""


def table(seed, craft=12, flights=5, different=(), drifting=None):
    """A fleet: ``different`` maps craft to how many spreads its effectiveness is away."""
    generator = np.random.default_rng(seed)
    different = dict(different)
    rows = []
    for c in range(craft):
        own = {name: mean + between * generator.normal() for name, (mean, between, _, _) in SIZES.items()}
        own["dM_du"] += different.get(c, 0) * SIZES["dM_du"][1]
        for k in range(flights):
            row = dict.fromkeys(fleet.SCHEMA.names)
            row |= {"path": f"/logs/quad/craft-{c:02}/2026-01-{k + 1:02}.csv", "sha256": f"{c}-{k}", "status": "answered"}
            row |= {"verdict": "named", "effects": [], "parameters": []}
            for name, (_, _, within, error) in SIZES.items():
                value = own[name] + within * generator.normal() + error * generator.normal()
                value += 0.02 * k if c == drifting and name == "trim" else 0.0
                ends = {"low": value - 1.96 * error, "high": value + 1.96 * error}
                row["parameters"].append({"name": name, "of": "", "unit": "N m/rad", "value": value, **ends})
            rows.append(row)
    return pa.Table.from_pylist(rows, schema=fleet.SCHEMA)


def outliers(of):
    (kind,) = fleet.siblings(of)
    return {(craft.name, one.name) for one in kind.parameters for craft in one.craft if craft.outlier}


def test_alike_craft_are_rarely_told_apart():
    alarms = [seed for seed in range(200) if outliers(table(seed))]
    # one fleet in twenty is the level; 19 of 200 would be a chance of one in a hundred
    assert len(alarms) <= 18, alarms


def test_variances_are_found():
    kinds = [fleet.siblings(table(seed, craft=30))[0] for seed in range(20)]
    for name, (_, between, within, _) in SIZES.items():
        ones = [next(one for one in kind.parameters if one.name == name) for kind in kinds]
        assert np.median([one.spread for one in ones]) == pytest.approx(between, rel=0.15)
        assert np.median([one.within for one in ones]) == pytest.approx(within, rel=0.25)


def test_what_differs_is_found_even_where_two_do():
    found = [outliers(table(seed, different={3: 8})) for seed in range(20)]
    assert sum(one == {("craft-03", "dM_du")} for one in found) >= 18, found
    found = [outliers(table(seed, different={3: 9, 7: 9})) for seed in range(20)]
    assert sum({("craft-03", "dM_du"), ("craft-07", "dM_du")} <= one for one in found) >= 18, found


def test_drift_is_told_of_the_craft_that_drifts():
    (kind,) = fleet.siblings(table(1, flights=8, drifting=4))
    told = [(drift.craft, drift.parameter) for drift in kind.drifts if drift.p < 0.05]
    assert told == [("craft-04", "trim")] and kind.per == "day"
    (drift,) = [drift for drift in kind.drifts if drift.p < 0.05]
    assert drift.low < 0.02 < drift.high
    quiet = [drift for seed in range(40) for drift in fleet.siblings(table(seed, flights=8))[0].drifts if drift.p < 0.05]
    assert len(quiet) <= 6, quiet


def test_copies_count_once_and_paths_name_the_craft():
    of = table(1)
    twice = pa.concat_tables([of, of.set_column(0, "path", pa.array([f"/copy{path}" for path in of["path"].to_pylist()]))])
    assert len(fleet.estimates(twice)) == len(fleet.estimates(of))
    rows = fleet.estimates(of, craft=r"(?P<type>quad)/craft-(?P<craft>\d+)/(?P<when>2026)")
    assert {row["craft"] for row in rows} == {f"{c:02}" for c in range(12)} and rows[0]["when"] is None
    assert fleet.estimates(of)[0]["when"].isoformat() == "2026-01-01T00:00:00"


def test_numbers_read_well():
    from pitchid.fleet.page import number, odds

    told = [number(x) for x in (0.0, 23.24, -0.00954, 2.62e-5, 1234.5, float("nan"))]
    assert told == ["0", "23.2", "−0.00954", "2.62e−5", "1234", "–"]
    assert odds(1.0) == "is what chance gives" and odds(1 / 2600) == "comes by chance in one fleet of 2,600"


def test_the_page_tells_who_differs(tmp_path):
    of = table(2, different={3: 9}, drifting=5, flights=8)
    bad = dict.fromkeys(fleet.SCHEMA.names) | {"path": "/logs/<b>.csv", "status": "failed", "error": "no log", "remedy": "look"}
    of = pa.concat_tables([of, pa.Table.from_pylist([bad], schema=fleet.SCHEMA)])
    page = fleet.report(of, out=tmp_path / "page.html")
    assert (tmp_path / "page.html").read_text() == page
    assert page.startswith("<!DOCTYPE html>") and "craft-03" in page and "differ" in page
    assert "one fleet of" in page and "drifts: " in page and "<svg" in page
    assert "/logs/&lt;b&gt;.csv" in page and "<b>.csv" not in page
    quiet = fleet.report(table(4))
    assert "No craft differs from its siblings" in quiet
    assert "No craft" in fleet.report(pa.Table.from_pylist([], schema=fleet.SCHEMA))
