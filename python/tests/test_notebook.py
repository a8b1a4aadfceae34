"""The notebook runs from its log to its decision."""

from pathlib import Path

import pytest

nbclient = pytest.importorskip("nbclient")
nbformat = pytest.importorskip("nbformat")

NOTEBOOK = Path(__file__).parents[1] / "examples/from_a_log_to_a_decision.ipynb"


def test_the_notebook_comes_to_its_decision(tmp_path):
    book = nbformat.read(NOTEBOOK, as_version=4)
    assert not any(cell.get("outputs") for cell in book.cells), "kept without its outputs"
    nbclient.NotebookClient(book, timeout=300, resources={"metadata": {"path": str(tmp_path)}}).execute()
    outputs = [output for cell in book.cells if cell.cell_type == "code" for output in cell.outputs]
    printed = "".join(output.text for output in outputs if output.output_type == "stream")
    assert "replace the bearing" in printed and "it helped" in printed
    shown = [output.data.get("text/html", "") for output in outputs if output.output_type == "execute_result"]
    assert any(html.startswith("<iframe") for html in shown), "the report stands in it"
