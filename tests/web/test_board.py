"""The board: its clock, what is late, what jumps back, and frames that say the same as the state."""

import json

import numpy as np
import pytest
from ddh_twin_py.web.board import MOST_ROWS, SILENT, Board
from ddh_twin_py.web.frames import Block, decode, encode
from ddh_twin_py.web.history import GRID_NS
from ddh_twin_py.web.quantities import FIRST_CHARTS, quantities
from ddh_twin_py.web.streams import BY_NAME, COLUMNS, FIRST, NUMBER, PLACE, STREAMS

WIDTHS = [len(stream.fields) for stream in STREAMS]


@pytest.fixture
def board():
    return Board()


def drive(board, *rows, value=1.0):
    """One sample in the middle of each row."""
    stamps = np.array(rows, np.int64) * GRID_NS - GRID_NS // 2
    board.take("drive", stamps, np.full((len(rows), WIDTHS[NUMBER["drive"]]), value))


def model(board, *rows, value=2.0):
    board.take("state", np.array(rows, np.int64) * GRID_NS, np.full((len(rows), WIDTHS[NUMBER["state"]]), value))


def column(board, name, count=20):
    return board.look_back(0, [name], count * GRID_NS * 1e-9)[1][:, 0]


def test_every_column_of_a_chart_is_there_and_no_quantity_twice():
    listed = quantities()
    names = [q["id"] for q in listed]
    assert len(names) == len(set(names)) and set(FIRST_CHARTS) <= set(names)
    for q in listed:
        for line in q["lines"]:
            assert line["column"] in PLACE and line.get("band", COLUMNS[0]) in PLACE, q["id"]
    assert len(COLUMNS) == len(set(COLUMNS)) == sum(WIDTHS)


def test_a_legend_tells_a_sensor_s_noise_from_the_uncertainty_of_an_estimate():
    spreads = {line["band"].split(".")[0]: line["spread"] for q in quantities() for line in q["lines"] if "band" in line}
    assert spreads == {"noise": "2 × sensor noise", "estimate": "2 σ", "innovation": "2 σ"}


def test_a_frame_holds_what_came_since_the_last_one_and_only_once(board):
    drive(board, 1000, 1001, 1002, value=5.0)
    number, now, blocks = decode(board.frame(), WIDTHS)
    assert (number, now) == (1, 1001)  # row 1002 may get more samples
    (block,) = blocks
    assert block.stream == NUMBER["drive"] and block.index.tolist() == [1000, 1001] and (block.values == 5.0).all()
    assert decode(board.frame(), WIDTHS)[2] == []
    board.settle("drive")
    assert decode(board.frame(), WIDTHS)[2][0].index.tolist() == [1002]
    assert board.latest("drive.speed") == 5.0


def test_a_snapshot_holds_the_newest_of_every_stream(board):
    drive(board, 1000, 1001, 1002)
    model(board, 990, 991)
    board.frame()
    number, now, blocks = decode(board.snapshot(), WIDTHS)
    assert (number, now) == (1, 1001)
    assert {b.stream: b.index.tolist() for b in blocks} == {NUMBER["drive"]: [1001], NUMBER["state"]: [991]}


def test_at_a_high_rate_a_frame_is_thinned_and_the_history_is_not(board):
    drive(board, *range(1000, 1101))
    (block,) = decode(board.frame(), WIDTHS)[2]
    assert block.index.size == MOST_ROWS and block.index[-1] == 1099
    assert np.isfinite(column(board, "drive.speed", 90)).all()


def test_what_comes_late_goes_to_its_place_and_a_jump_back_is_followed(board):
    drive(board, *range(1000, 1010))
    model(board, *range(900, 1000))
    model(board, 950, value=9.0)
    speed = column(board, "state.speed", 100)
    assert board.latest("state.speed") == 2.0 and board.jumps == 0
    assert np.nanmax(speed) == 9.0 and np.flatnonzero(speed == 9.0).tolist() == [950 - (board.now - 99)]
    drive(board, *range(500, 506), value=7.0)
    assert board.now == 504 and board.jumps == 1
    assert (column(board, "drive.speed", 5)[-5:] == 7.0).all()


def test_what_a_model_says_of_the_time_before_a_jump_is_left_out(board):
    drive(board, *range(1000, 1010))
    model(board, *range(990, 1000))
    drive(board, *range(500, 506))
    model(board, 1000, 1001, value=9.0)
    assert board.latest("state.speed") == 2.0 and board.now == 504
    model(board, 495, 496, value=3.0)
    assert board.latest("state.speed") == 3.0
    assert np.nanmax(column(board, "state.speed", 10)) == 3.0
    drive(board, *range(506, 1010))  # up to where the first round was: nothing of it is left
    assert np.isnan(column(board, "state.speed", 30)).all()


def test_without_telemetry_the_models_are_the_clock(board):
    model(board, 700, 701)
    assert board.now == 701
    model(board, 300)
    assert board.now == 300


@pytest.mark.parametrize("silent", [True, False])
def test_where_the_drive_falls_silent_the_others_go_on_and_it_leads_again_once_it_is_back(silent):
    wall = [0.0]
    board = Board(lambda: wall[0])
    drive(board, *range(1000, 1003))
    wall[0] += 1.01 * SILENT if silent else 0.5 * SILENT
    model(board, *range(1003, 1101))
    assert board.now == (1100 if silent else 1001)
    assert board.latest("state.speed") == 2.0
    drive(board, *range(1101, 1104))
    assert board.now == 1102 and board.jumps == 0
    model(board, 2000, value=9.0)  # the drive leads: what is far ahead of it is left out
    assert board.latest("state.speed") == 2.0


def test_documents_are_sent_where_they_change_and_hold_no_infinity(board):
    board.put("limits", {"time": float("inf"), "of": [float("nan"), 1.5]})
    assert board.changed() == ["limits"] and board.changed() == []
    board.put("limits", {"time": float("inf"), "of": [float("nan"), 1.5]})
    assert board.changed() == []
    assert json.loads(board.texts()["limits"]) == {"doc": "limits", "data": {"time": None, "of": [None, 1.5]}}
    board.put("limits", None)
    assert board.changed() == ["limits"] and board.document("limits") is None


def test_the_state_is_json(board):
    drive(board, 1000, 1001, value=4.0)
    state = json.loads(json.dumps(board.state(), allow_nan=False))
    assert state["values"]["drive.speed"] == 4.0 and state["values"]["state.speed"] is None and state["row"] == 1000


def test_frames_survive_any_length_of_header():
    for count in range(1, 6):
        values = np.arange(count * 4, dtype=np.float32).reshape(count, 4)
        frame = encode(7, 10**10, [Block(0, 10**10 - np.arange(count), values)])
        assert (int.from_bytes(frame[:4], "little") + 4) % 4 == 0
        number, now, (block,) = decode(frame, [4])
        assert number == 7 and now == 10**10 and block.index[0] == now
        np.testing.assert_array_equal(block.values, values)


def test_columns_of_a_stream_stand_together():
    for stream in STREAMS:
        first = FIRST[stream.name]
        assert COLUMNS[first : first + len(stream.fields)] == BY_NAME[stream.name].columns


def test_a_message_that_holds_some_columns_leaves_the_others(board):
    width = WIDTHS[NUMBER["temperature_gap"]]
    first, second = np.full((1, width), np.nan), np.full((1, width), np.nan)
    first[0, 0], second[0, 1] = 1.0, 2.0
    for row, values in ((700, first), (710, second)):
        board.take("temperature_gap", np.array([row]) * GRID_NS, values)
    names = BY_NAME["temperature_gap"].columns
    assert [board.latest(name) for name in names[:2]] == [1.0, 2.0] and np.isnan(board.latest(names[2]))


def test_a_clock_that_jumps_back_with_every_other_sample_is_followed(board):
    drive(board, *(row for k in range(1500) for row in (1000 + k, 5000 + k)))
    assert board.now == 2499 and board.jumps == 1499  # the last row is not whole yet
