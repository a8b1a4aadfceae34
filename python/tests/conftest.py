"""Recordings that the package makes itself: the tests need nothing from outside."""

import pytest

import pitchid

MODEL = """\
[plant]
inertia_kg_m2 = 0.1705
delay_s = 0.06
dM_dq_N_m_s = -0.27
dM_du_N_m = 23.0
mount_k_N_m = 3.8689
mount_c_N_m_s = 0.02639
mount_J_kg_m2 = 5.0e-4
"""


@pytest.fixture(autouse=True)
def in_a_folder_of_its_own(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


@pytest.fixture(scope="session")
def place(tmp_path_factory):
    return tmp_path_factory.mktemp("flown")


@pytest.fixture(scope="session")
def model(place):
    path = place / "model.toml"
    path.write_text(MODEL)
    return path


@pytest.fixture(scope="session")
def flown():
    """A test with dry friction."""
    return pitchid.simulate(effects={"coulomb_friction": {"Mc": 0.1}}, seed=7)


@pytest.fixture(scope="session")
def friction(flown, place):
    path = place / "friction.csv"
    flown.recording.to_csv(path)
    return path


@pytest.fixture(scope="session")
def answer(friction, model):
    return pitchid.diagnose(friction, model=model)
