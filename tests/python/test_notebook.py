# SPDX-License-Identifier: Apache-2.0
"""The notebook runs from its first cell to its last, says and shows what it should, and is kept without its outputs.

Ends with 77 where numpy, matplotlib, nbclient or ipykernel is missing.
"""
import sys
from pathlib import Path

NOTEBOOK = Path(__file__).resolve().parents[2] / "examples" / "python" / "first_grasp.ipynb"


def check(holds, what):
    if not holds:
        sys.exit(f"{NOTEBOOK.name}: {what}")


def main():
    try:
        import ipykernel  # noqa: F401
        import matplotlib  # noqa: F401
        import nbclient
        import nbformat
        import numpy  # noqa: F401
    except ImportError as error:
        print(f"skipped: {error} (Debian: python3-nbclient, python3-ipykernel, python3-matplotlib)")
        return 77
    notebook = nbformat.read(NOTEBOOK, as_version=4)
    nbformat.validate(notebook)
    cells = [cell for cell in notebook.cells if cell.cell_type == "code"]
    check(all(not cell.outputs and cell.execution_count is None for cell in cells),
          "is kept with outputs; clear them: jupyter nbconvert --clear-output --inplace")
    # A cell that raises, as an assertion of the notebook does, ends the test with its traceback.
    nbclient.NotebookClient(notebook, timeout=300, kernel_name="python3").execute()
    texts = "".join(output.text for cell in cells for output in cell.outputs if output.output_type == "stream"
                    and output.name == "stdout")
    shown = [set(output.data) for cell in cells for output in cell.outputs if "data" in output]
    check(texts.startswith("held\n"), f"does not hold the box:\n{texts}")
    check(texts.count("friction ") == 4, f"does not tell of four frictions:\n{texts}")
    check(sum("image/png" in data for data in shown) == 1, "draws no figure")
    page = cells[-1].outputs[-1].data.get("text/html", "")
    check(page.startswith("<iframe srcdoc=") and len(page) > 100_000, f"does not show the recording: {page[:200]}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
