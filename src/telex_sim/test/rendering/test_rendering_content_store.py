import os
import time
from dataclasses import dataclass

import numpy as np
import pytest

from telex_sim.cameras.drawing.meshes.batching import merge_visuals
from telex_sim.scene import content_store
from telex_sim.scene.content_store import ContentStore, cache_folder, shared_store, sources
from telex_sim.scene.meshes.mesh_files import MeshFileError, load_mesh
from telex_sim.scene.textures.procedural import generate_texture
from telex_sim.scene.visual_scene import Visual, VisualShape

pytestmark = pytest.mark.slow

TEXTURE = "generated:concrete?seed=77"


@pytest.fixture(autouse=True)
def worth_everything(monkeypatch):
    monkeypatch.setattr(content_store, "_WORTH", 0.0)


def make_nothing(*arguments):
    raise AssertionError(f"made anew of {arguments}")


def kept(store, monkeypatch, function, *arguments):
    """What the store has, without the function's being called."""
    with monkeypatch.context() as patch:
        patch.setattr(make_nothing, "__module__", function.__module__)
        patch.setattr(make_nothing, "__qualname__", function.__qualname__)
        return store.get(make_nothing, *arguments)


def files(folder):
    return sorted(folder.iterdir())


def test_what_was_made_is_read_by_the_next_start(tmp_path, monkeypatch):
    made = ContentStore(tmp_path).get(generate_texture, TEXTURE)
    assert np.array_equal(made, generate_texture(TEXTURE))
    read = kept(ContentStore(tmp_path), monkeypatch, generate_texture, TEXTURE)
    assert np.array_equal(read, made)
    assert read.dtype == made.dtype


def test_tuples_and_missing_arrays_come_back(tmp_path, monkeypatch):
    visual = Visual("world", VisualShape.BOX, (1.0, 2.0, 3.0))
    vertices, triangles = ContentStore(tmp_path).get(merge_visuals, (visual,), [None])
    read = kept(ContentStore(tmp_path), monkeypatch, merge_visuals, (visual,), [None])
    assert read[0].dtype == vertices.dtype
    assert read[0].tobytes() == vertices.tobytes()
    assert np.array_equal(read[1], triangles)
    path = tmp_path / "part.obj"
    path.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    store = ContentStore(tmp_path / "store")
    (tmp_path / "store").mkdir()
    positions, normals, uvs, triangles = store.get(load_mesh, path)
    read = kept(store, monkeypatch, load_mesh, path)
    assert uvs is read[2] is None
    assert all(np.array_equal(a, b) for a, b in zip(read[:2], (positions, normals)))
    # A file stands for its content, wherever it lies.
    other = tmp_path / "same.obj"
    other.write_bytes(path.read_bytes())
    kept(store, monkeypatch, load_mesh, other)
    other.write_text(other.read_text() + "# changed\n")
    with pytest.raises(AssertionError, match="made anew"):
        kept(store, monkeypatch, load_mesh, other)


def test_a_missing_file_is_refused_by_who_reads_it(tmp_path):
    with pytest.raises(MeshFileError, match=r"gone\.obj"):
        ContentStore(tmp_path).get(load_mesh, tmp_path / "gone.obj")


@pytest.mark.parametrize(
    "spoil",
    [
        lambda content: b"",
        lambda content: content[:-5],
        lambda content: b"something else\n" + content,
        lambda content: content[:-1] + bytes([content[-1] ^ 1]),
        lambda content: content[:40] + bytes([content[40] ^ 1]) + content[41:],
    ],
)
def test_what_is_broken_is_made_anew(tmp_path, spoil):
    made = ContentStore(tmp_path).get(generate_texture, TEXTURE)
    (path,) = files(tmp_path)
    content = path.read_bytes()
    path.write_bytes(spoil(content))
    assert np.array_equal(ContentStore(tmp_path).get(generate_texture, TEXTURE), made)
    assert path.read_bytes() == content


@dataclass(frozen=True)
class Figures:
    name: str
    values: np.ndarray


def echo(*arguments):
    return np.array([time.perf_counter()])


def test_every_argument_counts(tmp_path):
    store = ContentStore(tmp_path)
    values = np.arange(4.0)
    calls = [
        (values,),
        (values.astype(np.float32),),
        (values.reshape(2, 2),),
        (values + 1.0,),
        ((values, 1),),
        (values, 1),
        (values, 1.5),
        ("values",),
        (Figures("a", values),),
        (Figures("b", values),),
        (Figures("a", values + 1.0),),
        (("a", "b"), "c"),
        ("a", ("b", "c")),
    ]
    first = [store.get(echo, *call)[0] for call in calls]
    assert len(set(first)) == len(calls) == len(files(tmp_path))
    assert [store.get(echo, *call)[0] for call in calls] == first


def test_the_sources_are_those_along_the_imports():
    package = "telex_sim.scene.textures."
    found = sources("telex_sim.scene.textures.procedural")
    short = {name[len(package) :] for name in found if name.startswith(package)}
    assert {"procedural", "optotypes", "noise_patterns", "labels"} <= short
    assert not [name for name in found if name.startswith("telex_sim.cameras")]


def test_other_sources_are_other_content(tmp_path, monkeypatch):
    ContentStore(tmp_path).get(generate_texture, TEXTURE)
    monkeypatch.setattr(content_store, "_digest", lambda module: b"another version")
    ContentStore(tmp_path).get(generate_texture, TEXTURE)
    assert len(files(tmp_path)) == 2


def test_what_was_not_used_for_longest_goes(tmp_path):
    size = generate_texture(TEXTURE).nbytes
    store = ContentStore(tmp_path, most_bytes=round(3.5 * size))
    for number in range(3):
        store.get(generate_texture, f"generated:concrete?seed={number}")
        for path in files(tmp_path):
            os.utime(path, (path.stat().st_mtime - 1e6,) * 2)
    oldest = min(files(tmp_path), key=lambda path: path.stat().st_mtime)
    # Whoever is used becomes young again.
    store.get(generate_texture, "generated:concrete?seed=0")
    assert time.time() - oldest.stat().st_mtime < 1e5
    before = set(files(tmp_path))
    store.get(generate_texture, "generated:concrete?seed=3")
    gone = before - set(files(tmp_path))
    assert gone
    assert oldest not in gone
    assert sum(path.stat().st_size for path in files(tmp_path)) <= 3.5 * size


def test_the_folder_is_in_the_users_cache(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert cache_folder("content") == tmp_path / "telex_sim" / "content"
    shared_store().get(generate_texture, TEXTURE)
    assert len(files(tmp_path / "telex_sim" / "content")) == 1
    monkeypatch.setenv("XDG_CACHE_HOME", "relative")
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    assert cache_folder("content") == tmp_path / "home" / ".cache" / "telex_sim" / "content"


def test_without_a_folder_all_is_made_anew(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    assert cache_folder("content") is None
    assert np.array_equal(shared_store().get(generate_texture, TEXTURE), generate_texture(TEXTURE))


def test_a_folder_that_vanishes_costs_only_time(tmp_path):
    store = ContentStore(tmp_path / "never made")
    assert np.array_equal(store.get(generate_texture, TEXTURE), generate_texture(TEXTURE))
