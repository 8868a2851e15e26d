"""Bytes of a terminal to key events, whole or cut anywhere."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from telex_teleop.keyboard.decoding import FocusEvent, KeyDecoder, KeyEvent, KeyKind, KittyReply

TYPED, PRESSED = KeyKind.TYPED, KeyKind.PRESSED
REPEATED, RELEASED = KeyKind.REPEATED, KeyKind.RELEASED


def decode(data, exact=False):
    decoder = KeyDecoder()
    if exact:
        decoder.feed(b"\x1b[?15u", 0.0)
    return decoder.feed(data, 0.0)


def typed(*names):
    return [KeyEvent(name, name, TYPED) for name in names]


@pytest.mark.parametrize(
    ("data", "names"),
    [
        (b"wW1?", ["w", "W", "1", "?"]),
        (b" \t\r\x7f", ["space", "tab", "enter", "backspace"]),
        (b"\x03\x04\x12", ["ctrl+c", "ctrl+d", "ctrl+r"]),
        ("äß€".encode(), ["ä", "ß", "€"]),
        (b"\x1b[A\x1b[B\x1b[C\x1b[D", ["up", "down", "right", "left"]),
        (b"\x1bOA\x1bOP", ["up", "f1"]),
        (b"\x1b[1;5A", ["ctrl+up"]),
        (b"\x1b[3~\x1b[5~\x1b[15~\x1b[17~", ["delete", "pageup", "f5", "f6"]),
        (b"\x1b[Z", ["shift+tab"]),
        (b"\x1bx", ["escape", "x"]),
    ],
)
def test_keys_as_terminals_type_them(data, names):
    events = decode(data)
    assert [event.name for event in events] == names
    assert {event.kind for event in events} == {TYPED}


def test_lone_escape_is_known_after_a_moment():
    decoder = KeyDecoder(escape_time=0.05)
    assert decoder.feed(b"\x1b", 1.0) == []
    assert decoder.incomplete
    assert decoder.feed(b"", 1.02) == []
    assert decoder.feed(b"", 1.06) == typed("escape")
    assert not decoder.incomplete


def test_escape_twice_and_escape_before_a_sequence():
    assert decode(b"\x1b\x1b[A") == typed("escape", "up")


def test_sequence_that_breaks_off_does_not_block_what_follows():
    decoder = KeyDecoder()
    assert decoder.feed(b"\x1b[1;", 1.0) == []
    assert decoder.feed(b"", 2.0) == typed("escape")
    assert decoder.feed(b"w", 3.0) == typed("w")


@pytest.mark.parametrize(
    "second", [b"[", b"O", b"P", b"X", b"^", b"_", b"]", b"\xc3", b"[1;", b"[ "]
)
def test_escape_before_another_key_is_still_escape(second):
    decoder = KeyDecoder(escape_time=0.05)
    assert decoder.feed(b"\x1b", 1.0) == []
    assert decoder.feed(second, 1.03) == []
    assert decoder.feed(b"", 1.06) == typed("escape")
    assert not decoder.incomplete


@pytest.mark.parametrize("second", [b"[", b"P", b"]"])
def test_keys_that_repeat_do_not_hold_escape_back(second):
    decoder = KeyDecoder(escape_time=0.05)
    events = decoder.feed(b"\x1b" + second, 1.0)
    for tick in range(1, 5):
        events += decoder.feed(b"1", 1.0 + 0.03 * tick)
    assert events[0] == typed("escape")[0]


@pytest.mark.parametrize("data", [b"\x1b[w", b"\x1b[u", b"\x1bOj", b"\x1b[ w", b"\x1b[5w"])
def test_what_no_terminal_sends_was_escape_and_no_other_key(data):
    assert decode(data) == typed("escape")


@pytest.mark.parametrize(
    ("data", "names"),
    [
        (b"\x1b\x03", ["escape", "ctrl+c"]),
        (b"\x1b ", ["escape", "space"]),
        (b"\x1b[\x03", ["escape", "ctrl+c"]),
        (b"\x1bO\x03", ["escape", "ctrl+c"]),
        (b"\x1b[\x1b[A", ["escape", "up"]),
    ],
)
def test_stop_and_quit_right_after_escape_are_not_lost(data, names):
    assert decode(data) == typed(*names)


def test_alt_is_known_where_a_key_has_it():
    decoder = KeyDecoder({"alt+x"})
    assert decoder.feed(b"\x1bx\x1by", 1.0) == typed("alt+x", "escape", "y")


def test_endless_sequence_is_given_up():
    assert decode(b"\x1b]" + b"1" * 5000) == typed("escape")


def test_pasted_text_is_no_command():
    assert decode(b"\x1b[200~wasd\x1b[A\x1b[201~r") == typed("r")


def test_paste_that_does_not_end_ends():
    decoder = KeyDecoder()
    assert decoder.feed(b"\x1b[200~abc", 1.0) == []
    assert decoder.feed(b"w", 1.2) == []
    assert decoder.feed(b"", 1.55) == []
    assert decoder.feed(b" \x03", 1.6) == typed("space", "ctrl+c")


def test_paste_that_we_were_late_to_read_goes_on():
    decoder = KeyDecoder()
    decoder.feed(b"\x1b[200~abc", 1.0)
    assert decoder.feed(b"wasd\x1b[201~r", 3.0) == typed("r")


def test_escape_counts_in_a_paste_that_does_not_end():
    decoder = KeyDecoder()
    decoder.feed(b"\x1b[200~abc", 1.0)
    decoder.feed(b"\x1b", 1.1)
    assert decoder.feed(b"", 1.2) == typed("escape")


def test_focus():
    assert decode(b"\x1b[O\x1b[I") == [FocusEvent(False), FocusEvent(True)]


def test_answers_of_the_terminal_are_no_keys():
    assert decode(b"\x1b[?62;4c\x1bP>|kitty\x1b\\\x1b]11;rgb:0/0/0\x07w") == typed("w")


def test_kitty_answers():
    assert decode(b"\x1b[?0u\x1b[?15u") == [KittyReply(False), KittyReply(True)]


@pytest.mark.parametrize(
    ("data", "name", "key", "kind"),
    [
        (b"\x1b[119u", "w", "119", PRESSED),
        (b"\x1b[119;1:1u", "w", "119", PRESSED),
        (b"\x1b[119;1:2u", "w", "119", REPEATED),
        (b"\x1b[119;1:3u", "w", "119", RELEASED),
        (b"\x1b[119:87;2:1u", "W", "119", PRESSED),
        (b"\x1b[119;2u", "W", "119", PRESSED),
        (b"\x1b[47:63;2u", "?", "47", PRESSED),
        (b"\x1b[119;65u", "w", "119", PRESSED),  # caps lock
        (b"\x1b[99;5u", "ctrl+c", "99", PRESSED),
        (b"\x1b[32u", "space", "32", PRESSED),
        (b"\x1b[27u", "escape", "27", PRESSED),
        (b"\x1b[57401u", "2", "57401", PRESSED),
        (b"\x1b[57413u", "+", "57413", PRESSED),
        (b"\x1b[A", "up", "up", PRESSED),
        (b"\x1b[1;1:3A", "up", "up", RELEASED),
        (b"\x1b[1;2A", "shift+up", "up", PRESSED),
        (b"\x1b[5;1:3~", "pageup", "pageup", RELEASED),
    ],
)
def test_keys_as_kitty_reports_them(data, name, key, kind):
    assert decode(data, exact=True) == [KeyEvent(name, key, kind)]


@pytest.mark.parametrize("data", [b"\x1b[57441;2u", b"\x1b[99999999u", b"\x1b[;u"])
def test_modifiers_and_nonsense_are_no_keys(data):
    assert decode(data, exact=True) == []


def test_release_keeps_its_key_when_shift_came_meanwhile():
    press, release = decode(b"\x1b[119u\x1b[119:87;2:3u", exact=True)
    assert press.key == release.key


SAMPLES = b"w\x1b[A\x1b[119;1:3u\x1b[O\x1b[?15u\xc3\xa4\x1bOP \x1b[1;5A\x03"


@given(st.lists(st.integers(0, len(SAMPLES)), max_size=6))
def test_cuts_change_nothing(cuts):
    decoder, events, start = KeyDecoder(), [], 0
    for cut in [*sorted(cuts), len(SAMPLES)]:
        events += decoder.feed(SAMPLES[start:cut], 0.0)
        start = cut
    assert events == decode(SAMPLES)


@given(st.binary(max_size=200))
def test_any_bytes_end_somewhere(data):
    decoder = KeyDecoder()
    decoder.feed(data, 0.0)
    decoder.feed(b"", 1.0)
    assert not decoder.incomplete
