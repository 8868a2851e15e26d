"""Recordings: written in the order of arrival, read back the same, whatever goes wrong."""

import io
import os
import random
import signal
import statistics
import subprocess
import sys
import threading
import time

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from std_msgs.msg import String

from telex_training.judging.entries import Entry
from telex_training.recording import reader
from telex_training.recording import writer as writing
from telex_training.recording.inbox import Inbox
from telex_training.recording.reader import read_recording, repair
from telex_training.recording.writer import Attachment, RecordingError, RecordingWriter, check_room


def serialised(text):
    file = io.BytesIO()
    String(text).serialize(file)
    return file.getvalue()


def entries(count, size=200):
    numbers = random.Random(count)
    return [
        Entry(
            number,
            number * 20_000_000 / 1e9,
            f"topic_{number % 3}",
            "std_msgs/String",
            serialised(numbers.randbytes(size).hex()),
        )
        for number in range(count)
    ]


def record(path, made, attachments=None, ending=None):
    writer = RecordingWriter(path, attachments or {})
    for entry in made:
        writer.put(entry, 1_700_000_000_000_000_000 + entry.number)
    writer.close(ending or {})


class TestWholeRecordings:
    def test_what_was_put_in_is_read_back(self, tmp_path):
        path, made = tmp_path / "a.mcap", entries(500)
        record(
            path,
            made,
            {"exercise.yaml": Attachment("text/yaml", b"name: x")},
            {"sheet.json": Attachment("application/json", b"{}")},
        )
        found = read_recording(path)
        assert found.whole
        assert found.entries == made
        assert found.walls[3] == 1_700_000_000_000_000_003
        assert found.attachments["exercise.yaml"].data == b"name: x"
        assert found.attachments["sheet.json"].media_type == "application/json"

    @given(st.integers(0, 10**15))
    def test_every_time_is_read_back_exactly(self, nanoseconds):
        time_s = nanoseconds / 1e9
        assert round(time_s * 1e9) / 1e9 == time_s

    def test_other_readers_find_the_definition_of_each_type(self, tmp_path):
        from mcap.reader import make_reader

        path = tmp_path / "a.mcap"
        record(path, entries(10))
        with path.open("rb") as file:
            reader = make_reader(file)
            assert reader.get_header().profile == "ros1"
            schema, channel, message = next(reader.iter_messages())
        assert (schema.name, schema.encoding) == ("std_msgs/String", "ros1msg")
        assert b"string data" in schema.data
        assert channel.message_encoding == "ros1"

    def test_an_existing_file_is_not_overwritten(self, tmp_path):
        path = tmp_path / "a.mcap"
        path.write_text("precious")
        with pytest.raises(RecordingError, match="a.mcap: File exists"):
            RecordingWriter(path, {})
        assert path.read_text() == "precious"

    def test_chunks_are_small_enough_to_lose_little(self, tmp_path):
        path = tmp_path / "a.mcap"
        record(path, entries(1000))
        from mcap.reader import make_reader

        with path.open("rb") as file:
            summary = make_reader(file).get_summary()
        assert len(summary.chunk_indexes) >= 1000 * 400 // writing.CHUNK
        assert max(each.uncompressed_size for each in summary.chunk_indexes) < 2 * writing.CHUNK


class TestInbox:
    def test_record_and_judgement_have_the_same_order_from_many_threads(self, tmp_path):
        path, judged = tmp_path / "a.mcap", []
        writer = RecordingWriter(path, {})
        inbox = Inbox(judged.append, writer)

        def send(channel):
            for number in range(500):
                inbox.put(channel, "std_msgs/String", serialised(f"{channel} {number}"), number)

        threads = [threading.Thread(target=send, args=(f"t{each}",)) for each in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        inbox.close()
        writer.close({})
        assert [entry.number for entry in judged] == list(range(2000))
        assert read_recording(path).entries == judged

    def test_nothing_is_taken_after_its_end(self):
        judged = []
        inbox = Inbox(judged.append)
        inbox.put("a", "std_msgs/String", serialised("a"), 0)
        inbox.close()
        inbox.put("a", "std_msgs/String", serialised("b"), 1)
        assert len(judged) == 1

    def test_a_disk_that_stands_loses_nothing_and_holds_nobody(self, tmp_path, monkeypatch):
        path, judged = tmp_path / "a.mcap", []
        stands, goes_on = threading.Event(), threading.Event()
        writer = RecordingWriter(path, {}, sync_period=0.1)
        real = os.fsync

        def slow(handle):
            stands.set()
            assert goes_on.wait(60.0), "somebody has waited for the disk"
            real(handle)

        monkeypatch.setattr(writing.os, "fsync", slow)
        inbox = Inbox(judged.append, writer)
        for number in range(200):
            if number == 25:
                assert stands.wait(60.0)
            elif number == 175:
                # All of three seconds.
                assert writer.waiting >= 150
                goes_on.set()
            inbox.put("sim/truth", "std_msgs/String", serialised("x" * 300), number * 20_000_000)
        inbox.close()
        writer.close({})
        found = read_recording(path)
        assert [entry.number for entry in found.entries] == list(range(200))


CHILD = """
import sys, time
from pathlib import Path
from telex_training.recording.trial_file import input_entry
from telex_training.recording.writer import RecordingWriter
writer = RecordingWriter(Path(sys.argv[1]), {})
for number in range(10**6):
    writer.put(input_entry(number, 20_000_000 * number, {"input": f"{number:0170d}"}), 0)
    print(number, writer.waiting, flush=True)
    time.sleep(0.002)
"""


class TestBrokenRecordings:
    @pytest.mark.real_time
    def test_a_killed_process_loses_two_seconds_at_most(self, tmp_path):
        path = tmp_path / "a.mcap"
        child = subprocess.Popen(
            [sys.executable, "-c", CHILD, str(path)], stdout=subprocess.PIPE, text=True
        )
        lines = []
        for line in child.stdout:
            lines.append(line)
            if int(line.split()[0]) >= 600:
                break
        child.send_signal(signal.SIGKILL)
        # The last line may be cut off.
        *rest, _ = child.stdout.read().split("\n")
        child.wait()
        told = [tuple(map(int, each.split())) for each in [*lines, *rest]]
        last, waiting = told[-1]
        # It is written as it comes.
        assert statistics.median(each for _, each in told) < 20
        found = repair(path)
        assert found.whole
        assert [entry.number for entry in found.entries] == list(range(len(found.entries)))
        # Beyond what a busy machine did not let it write.
        assert (last - waiting - len(found.entries)) * 0.02 <= 2.0

    @pytest.mark.parametrize("share", [0.3, 0.7, 0.99])
    def test_a_file_that_is_cut_off_keeps_all_but_its_last_chunk(self, tmp_path, share):
        path, made = tmp_path / "a.mcap", entries(600)
        record(path, made, {"exercise.yaml": Attachment("text/yaml", b"name: x")})
        content = path.read_bytes()
        path.write_bytes(content[: int(share * len(content))])
        cut = read_recording(path)
        assert not cut.whole
        found = repair(path)
        assert found.whole
        assert found.entries == cut.entries == made[: len(found.entries)]
        assert len(found.entries) >= share * 600 - 2 * writing.CHUNK / 400 - 30
        assert found.attachments["exercise.yaml"].data == b"name: x"
        assert [file.name for file in tmp_path.iterdir()] == ["a.mcap"]

    def test_a_whole_one_is_left_alone(self, tmp_path):
        path = tmp_path / "a.mcap"
        record(path, entries(20))
        before = (path.stat().st_mtime_ns, path.read_bytes())
        repair(path)
        assert (path.stat().st_mtime_ns, path.read_bytes()) == before

    @pytest.mark.parametrize("content", [b"", b"hello", b"\x89MCAP0\r\n", bytes(range(250)) * 8])
    def test_what_is_no_recording_is_refused(self, tmp_path, content):
        path = tmp_path / "a.mcap"
        path.write_bytes(content)
        with pytest.raises(RecordingError, match="a.mcap: it is no recording"):
            read_recording(path)

    def test_one_that_unpacks_to_more_than_is_read_is_refused(self, tmp_path, monkeypatch):
        path, made = tmp_path / "a.mcap", entries(10)
        record(path, made)
        size = sum(len(entry.data) for entry in made)
        monkeypatch.setattr(reader, "MOST_UNPACKED", size)
        assert len(read_recording(path).entries) == 10
        monkeypatch.setattr(reader, "MOST_UNPACKED", size - 1)
        with pytest.raises(RecordingError, match=rf"a\.mcap: .* more than the {size - 1} bytes"):
            read_recording(path)

    def test_a_missing_file_is_named(self, tmp_path):
        with pytest.raises(RecordingError, match="none.mcap: No such file"):
            read_recording(tmp_path / "none.mcap")

    @settings(max_examples=100, suppress_health_check=list(HealthCheck))
    @given(st.lists(st.tuples(st.floats(0.0, 1.0, exclude_max=True), st.integers(0, 255))))
    def test_damaged_bytes_never_crash_the_reader(self, tmp_path, damage):
        path = tmp_path / "a.mcap"
        path.unlink(missing_ok=True)
        record(path, entries(60, size=40))
        content = bytearray(path.read_bytes())
        for share, value in damage:
            content[int(share * len(content))] = value
        path.write_bytes(bytes(content))
        try:
            found = read_recording(path)
        except RecordingError:
            return
        assert len(found.entries) <= 60

    def test_a_full_disk_is_said_and_stops_nobody(self, tmp_path, monkeypatch):
        path = tmp_path / "a.mcap"
        writer = RecordingWriter(path, {}, sync_period=0.01)

        def full(handle):
            raise OSError(28, "No space left on device")

        monkeypatch.setattr(writing.os, "fsync", full)
        for entry in entries(50):
            writer.put(entry, 0)
        deadline = time.monotonic() + 5.0
        while not writer.problem and time.monotonic() < deadline:
            time.sleep(0.01)
        assert writer.problem == "No space left on device"
        writer.put(entries(1)[0], 0)
        with pytest.raises(RecordingError, match="a.mcap: No space left on device"):
            writer.close({})


class TestRoom:
    def test_there_is_room_for_a_recording(self, tmp_path):
        check_room(tmp_path / "new" / "folder", least=1)
        assert (tmp_path / "new" / "folder").is_dir()

    def test_too_little_is_said_before(self, tmp_path):
        with pytest.raises(RecordingError, match=r"MB are free; at least \d+ MB are needed"):
            check_room(tmp_path, least=2**60)
