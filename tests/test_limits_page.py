"""The page of limits says what the constants say."""

from __future__ import annotations

from pathlib import Path

from flexdyn.batch import distributions, stored_study, study_keys
from flexdyn.diagnose.compared import report_file
from flexdyn.io import yaml
from flexdyn.records import bounds, meta, table
from flexdyn.records.apart import server as limits
from flexdyn.records.csv import file as csv_file
from flexdyn.records.hdf5 import file as hdf5_file
from flexdyn.records.matlab import columns, v73
from flexdyn.records.ros import definitions, guard, walk
from flexdyn.robot import meshes, urdf, values, xmlfile
from flexdyn.viewer import bodies

PAGE = Path(__file__).parents[1] / "docs" / "limits.md"
MIB = 2**20

ROWS = (
    ("every recording", f"{bounds.MOST_FILE // 2**40} TiB on disk"),
    ("", f"{bounds.MOST_BYTES // 2**30} GiB of numbers; no more than {bounds.USUAL_EXPANSION} times the file's size"),
    ("", f"{bounds.MOST_EXPANSION} times the file's size where that is up to {bounds.SMALL // MIB} MiB"),
    ("", f"{bounds.MOST_COLUMNS:,} columns, arrays, variables or datasets"),
    ("", f"{bounds.MOST_SAMPLES:,} rows"),
    ("", f"{table._LONGEST_NAME} letters in a channel's name; {meta._LONGEST_META // MIB} MiB of meta"),
    ("CSV", f"{csv_file._LONGEST_LINE // MIB} MiB in a line"),
    (
        "HDF5 and MAT",
        f"{limits.COMPUTING_SECONDS} s of computing, and 1 s more for every {limits.BYTES_A_SECOND:,} bytes",
    ),
    ("", f"{limits.WAITING} times that by the clock"),
    ("", f"{limits.BYTES // 2**30} GiB of memory, and twice what the numbers may take (Linux)"),
    ("", f"{hdf5_file._LARGEST_CHUNK // 2**30} GiB in a chunk; {hdf5_file._LONGEST_UNIT} bytes in a unit"),
    ("MAT", f"{columns.MOST_STRUCTS} structs in each other; {v73._LONGEST_TEXT // MIB} MiB of text in version 7.3"),
    ("bags and MCAP", f"{guard.MOST_MESSAGE // MIB} MiB in a message; {guard._LARGEST_CHUNK // 2**30} GiB in a chunk"),
    ("", f"{guard._MOST_OPEN // 2**30} GiB of chunks that overlap in time"),
    ("", f"{walk._MOST_STEPS:,} fields in a message, {walk._MOST_DEPTH} in each other"),
    ("", f"{definitions._LONGEST_DEFINITION // 1024} KiB in the definition of a message"),
    ("every YAML file", f"{yaml.MAX_YAML_BYTES:,} bytes; {yaml.MAX_DEPTH} lists and mappings in each other"),
    ("", f"{yaml.MAX_NODES:,} entries once aliases are unfolded; {yaml.MAX_BRACKETS:,} open brackets"),
    ("study", f"{study_keys.MAX_RUNS:,} runs; {distributions.MAX_GRID:,} values in a grid"),
    ("store of a study", f"{stored_study.MAX_STORE_BYTES:,} bytes in zarr.json; arrays with the shapes of the study"),
    ("", f"{stored_study.MAX_STUDY_LETTERS:,} letters in the study that it holds"),
    ("report.json of a diagnosis", f"{report_file.MAX_REPORT_BYTES:,} bytes"),
    (
        "URDF",
        f"{xmlfile.MAX_URDF_BYTES:,} bytes; 256 elements in each other; {xmlfile.MAX_ATTRIBUTES:,} attributes in one",
    ),
    ("", f"{urdf.MAX_LINKS:,} links; {urdf.MAX_JOINTS} joints that move; {values.LONGEST_NAME} letters in a name"),
    ("mesh", f"{meshes.MAX_MESH_BYTES:,} bytes; {meshes.MAX_MESHES_BYTES:,} bytes in all meshes of a robot"),
    ("", f"{bodies.LARGEST_MESH:,} triangles in a page, {bodies.LARGEST_ARM:,} of all meshes"),
)


def as_markdown() -> str:
    """The table as it stands in the page."""
    lines = ["| file | at most |", "| --- | --- |", *(f"| {what} | {bound} |" for what, bound in ROWS)]
    return "\n".join(lines)


def test_the_page_holds_the_table() -> None:
    """A constant that changes without its row fails here, with the right row to copy."""
    text = PAGE.read_text(encoding="utf-8")
    missing = [line for line in as_markdown().splitlines() if line not in text]
    assert not missing, "\n".join(missing)
    assert as_markdown() in text
