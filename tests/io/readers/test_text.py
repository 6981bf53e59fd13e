"""Text logs: however they are written, the numbers come out the same."""

import gzip
import tracemalloc
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fric import FricError
from fric.documents.mapping import Layout
from fric.io.ingest import ingest
from fric.io.readers import tables
from fric.io.readers.base import BLOCK
from fric.io.readers.text import encoding_of, shape_of

NAMES = ("time", "position", "velocity", "force")
UNITS = ("s", "µm", "mm/s", "N")


def read(path, layout=None):
    (table,) = tables(path, layout)
    parts = [block.columns for block in table.blocks(range(len(table.columns)))]
    return table, [np.concatenate(column) for column in zip(*parts, strict=True)]


finite = st.floats(-1e6, 1e6, allow_nan=False).map(lambda x: float(f"{x:.9g}"))


@st.composite
def written(draw):
    """A table of numbers, and one of the many ways to write it."""
    width = draw(st.integers(2, 4))
    values = draw(st.lists(st.lists(finite, min_size=width, max_size=width), min_size=3, max_size=12))
    delimiter, decimal = draw(st.sampled_from([";.", ";,", "	.", "	,", ",.", "|."]))
    style = draw(st.sampled_from(["{:.9g}", "{:.12e}", "{!r}", "{:+.9g}"]))
    space = draw(st.sampled_from(["", " "]))
    end = draw(st.sampled_from(["\n", "\r\n"]))
    header = draw(st.sampled_from(["named", "units beside", "units below", "none"]))
    preamble = draw(st.integers(0, 4)) if header != "none" else 0
    lines = [f"Date:{delimiter}2024-05-06 07:08:09", f"Samples:{delimiter}{len(values)}", "", "# a remark: 3 kg"][
        :preamble
    ]
    if header == "units beside":
        lines.append(delimiter.join(f"{n} [{u}]" for n, u in zip(NAMES[:width], UNITS, strict=False)))
    elif header != "none":
        lines.append(delimiter.join(NAMES[:width]))
        if header == "units below":
            lines.append(delimiter.join(UNITS[:width]))
    for row in values:
        cells = [style.format(value).replace(".", decimal) for value in row]
        lines.append((delimiter + space).join(cells))
    if draw(st.booleans()):
        lines.insert(len(lines) - 1, "")
    text = end.join(lines) + (end if draw(st.booleans()) else "")
    encoding = draw(st.sampled_from(["utf-8", "latin-1", "utf-8-sig", "utf-16"]))
    return text.encode(encoding), np.array(values), header, draw(st.booleans())


@settings(max_examples=60, deadline=None)
@given(written())
def test_any_way_of_writing_gives_the_same_numbers(case):
    data, values, header, zipped = case
    with TemporaryDirectory() as folder:
        path = Path(folder) / ("log.csv.gz" if zipped else "log.csv")
        path.write_bytes(gzip.compress(data) if zipped else data)
        table, columns = read(path)
    width = values.shape[1]
    np.testing.assert_allclose(np.array(columns).T, values, rtol=1e-14, atol=0)
    if header != "none":
        assert tuple(column.name for column in table.columns) == NAMES[:width]
    if header.startswith("units"):
        assert tuple(column.unit for column in table.columns) == UNITS[:width]


def test_spaces_and_a_name_with_a_unit_in_brackets(tmp_path):
    path = tmp_path / "log.txt"
    path.write_text("# time [s]  motor torque (Nm)   x (filtered)\n 0.0   1.5  2\n 0.1  -1.5  3\n")
    table, columns = read(path)
    assert [tuple(column) for column in table.columns] == [
        ("time", "s"),
        ("motor torque", "Nm"),
        ("x (filtered)", "filtered"),
    ]
    np.testing.assert_array_equal(columns, [[0.0, 0.1], [1.5, -1.5], [2, 3]])


def test_a_delimiter_at_the_end_of_each_line_is_no_column(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text("t;x;\n0,1;2;\n0,2;3;\n0,3;4;\n")
    table, columns = read(path)
    assert len(table.columns) == 2
    np.testing.assert_array_equal(columns, [[0.1, 0.2, 0.3], [2, 3, 4]])


@pytest.mark.parametrize(
    ("decimal", "mark"), [(".", ","), (".", " "), (".", "'"), (".", "\u202f"), (",", "."), (",", "’")]
)
def test_marks_between_thousands_are_read(tmp_path, decimal, mark):
    """The first rows have none, as a position that begins at 0."""
    path, values = tmp_path / "log.csv", [0.5, 999.25, 1000.5, -12345.75, 1234567.5]

    def written(value):
        return f"{value:,.2f}".translate({ord(","): mark, ord("."): decimal})

    rows = "".join(f"{written(n / 10)};{written(value)};{n + 1}\n" for n, value in enumerate(values))
    path.write_text("t;x;y\n" + rows, encoding="utf-8")
    _, columns = read(path)
    np.testing.assert_array_equal(columns[1], values)


def test_columns_of_words_are_passed_over(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text("state,time,x\nRUN,0.1,2\nRUN,0.2,3\nHOLD,0.3,4\n")
    table, columns = read(path)
    assert [column.name for column in table.columns] == ["state", "time", "x"]
    np.testing.assert_array_equal(columns[1:], [[0.1, 0.2, 0.3], [2, 3, 4]])
    assert np.isnan(columns[0]).all()


def test_the_preamble_serves_as_fields(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text('Sampling period:;51.200\nTrigger:;"Channel 1"\n# load: 3 kg\n;v\nms;rpm\n0;1\n1;2\n')
    table, _ = read(path)
    assert table.constants == {"Sampling period": "51.200", "Trigger": "Channel 1", "load": "3 kg"}
    assert table.columns[0].unit == "ms"


def test_what_the_user_says_goes_before_what_is_found(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text("1,2\n3,4\n5,6\n7,8\n")
    _, found = read(path)
    np.testing.assert_array_equal(found, [[1, 3, 5, 7], [2, 4, 6, 8]])
    _, said = read(path, Layout(delimiter=";", decimal=","))
    np.testing.assert_array_equal(said, [[1.2, 3.4, 5.6, 7.8]])
    table, said = read(path, Layout(header=2))
    assert [column.name for column in table.columns] == ["3", "4"]
    np.testing.assert_array_equal(said, [[5, 7], [6, 8]])


def test_comments_and_skipped_lines(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text("9,9\ntime,x\n0,1 % good\n% a remark\n1,x\n")
    table, columns = read(path, Layout(skip=1, comment="%"))
    np.testing.assert_array_equal(columns, [[0, 1], [1, np.nan]])
    assert table.place(1, 1).endswith("line 5, column 'x'")
    assert table.text(1, 1) == "x"


@pytest.mark.parametrize("rows", [BLOCK - 1, BLOCK, BLOCK + 1, 2 * BLOCK + 7])
def test_blocks_join_without_a_seam(tmp_path, rows):
    path = tmp_path / "log.csv"
    path.write_text("n,m\n" + "".join(f"{n},{-n}\n" for n in range(rows)))
    _, columns = read(path)
    np.testing.assert_array_equal(columns[0], np.arange(rows))
    np.testing.assert_array_equal(columns[1], -np.arange(rows))


def test_a_cut_gz_is_told(tmp_path):
    path = tmp_path / "log.csv.gz"
    noise = np.random.default_rng(0).random(20_000)
    data = gzip.compress("\n".join(f"{n},{x:.17g}" for n, x in enumerate(noise)).encode())
    path.write_bytes(data[:-2000])
    with pytest.raises(FricError, match="is damaged"):
        read(path)


def test_encodings():
    assert encoding_of("µm".encode("latin-1")) == "latin-1"
    assert encoding_of("µm".encode()) == "utf-8"
    assert encoding_of("µm".encode("utf-16")) == "utf-16"
    # a letter of two bytes that is cut at the end of what is looked at
    assert encoding_of("a\nµ".encode()[:-1]) == "utf-8"
    assert shape_of(b"t [s],x [\xb5m]\n0,1\n1,2\n", Layout(), whole=True).columns[1].unit == "µm"


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("at", [0, 1, 3, 30])
@pytest.mark.parametrize(("tail", "good"), [(",,", True), (",,7", False), (",7", False), ("," * 300, False)])
def test_cells_behind_those_of_the_header_are_empty_or_told(tmp_path, at, tail, good):
    """Of which pandas left out some and printed a warning."""
    path = tmp_path / "log.csv"
    rows = [f"{0.1 * n},2.0{tail * (n == at)}\n" for n in range(60)]
    path.write_text("time [s],position [m]\n" + "".join(rows))
    if good:
        assert ingest(path, tmp_path / "log.h5").samples == 60
    else:
        with pytest.raises(FricError, match=f"line {at + 2}:? has more cells than the 2 of the header"):
            ingest(path, tmp_path / "log.h5")


def test_a_row_of_many_empty_cells_takes_no_memory(tmp_path):
    """30,000 cells of a first row were as many levels of an index: 200,000 took 1.8 GB."""
    path = tmp_path / "log.csv"
    path.write_text("time [s],position [m]\n0,1" + "," * 30_000 + "\n" + "1,2\n" * 60)
    tracemalloc.start()
    try:
        with pytest.raises(FricError, match="line 2: has more cells than the 2 of the header"):
            ingest(path, tmp_path / "log.h5")
        assert tracemalloc.get_traced_memory()[1] < 50e6
    finally:
        tracemalloc.stop()


def test_a_state_that_lacks_is_no_word(tmp_path):
    (tmp_path / "log.csv").write_text("time [s],mode\n0,on\n1,\n2,off\n3,on\n")
    (table,) = tables(tmp_path / "log.csv")
    table.states = 1
    ((_, mode),) = (block.columns for block in table.read([0, 1]))
    assert table.labels == ("on", "off")
    np.testing.assert_array_equal(mode, [0.0, np.nan, 1.0, 0.0])
