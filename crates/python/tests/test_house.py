"""Tests pickles, threads, signals, forks, documentation, and types."""

import copy
import doctest
import hashlib
import importlib
import multiprocessing
import os
import pickle
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import intertri
import numpy as np
import pytest
from conftest import camera, icosphere


@pytest.fixture
def mesh(dtype):
    vertices, faces = icosphere(3)
    return intertri.Mesh(vertices.astype(dtype), faces)


def test_copies_answer_alike(mesh):
    eye, ways = camera(50, [1, 2, 3])
    hits = mesh.closest(eye.astype(mesh.dtype), ways.astype(mesh.dtype))
    copies = [copy.copy(mesh), copy.deepcopy(mesh)]
    copies += [pickle.loads(pickle.dumps(mesh, protocol)) for protocol in range(2, pickle.HIGHEST_PROTOCOL + 1)]
    for other in copies:
        assert other is not mesh and other.dtype == mesh.dtype and other.digest == mesh.digest
        assert (other.closest(eye.astype(mesh.dtype), ways.astype(mesh.dtype)) == hits).all()


def _whatever_has_threads(vertices, faces, rays):
    """Returns a digest of the answers of every kind of call that uses several threads."""
    mesh = intertri.Mesh(vertices, faces)
    mesh.refit(vertices * vertices.dtype.type(1.5))
    mesh = pickle.loads(pickle.dumps(mesh))
    points = rays[..., :3] + rays[..., 3:]
    answers = [mesh.closest(rays), mesh.any(rays), mesh.closest_triangle(rays), mesh.all(rays).hits,
               mesh.crossings(rays).hits, mesh.count_crossings(rays), mesh.contains(points), mesh.closest_point(points)]
    return hashlib.sha256(b"".join(answer.tobytes() for answer in answers)).hexdigest()


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork here")
@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")
def test_a_forked_process_has_threads_of_its_own(dtype):
    vertices, faces = icosphere(5)
    eye, ways = camera(100, [1, 2, 3])
    rays = np.concatenate([np.broadcast_to(eye, ways.shape), ways], axis=-1).astype(dtype)
    asked = vertices.astype(dtype), faces, rays
    truth = _whatever_has_threads(*asked)
    context = multiprocessing.get_context("fork")
    queue = context.Queue()
    child = context.Process(target=lambda: queue.put(_whatever_has_threads(*asked)))
    child.start()
    try:
        assert queue.get(timeout=60) == truth
    finally:
        child.kill()
        child.join()


@pytest.mark.skipif(not hasattr(os, "sched_getaffinity") or len(os.sched_getaffinity(0)) < 2, reason="one CPU")
def test_calls_of_one_thread_run_side_by_side(mesh):
    """Checks that a single-threaded query runs on the Python thread that calls it, so that queries
    from several threads can run in parallel."""
    rays = np.random.default_rng(1).uniform(-1, 1, (1_000_000, 6)).astype(mesh.dtype)
    spans = []

    def ask():
        used = time.thread_time()
        mesh.closest(rays, threads=1)
        spans.append(time.thread_time() - used)

    threads = [threading.Thread(target=ask) for _ in range(2)]
    [thread.start() for thread in threads]
    [thread.join() for thread in threads]
    # Each calling thread spends its own CPU time on its query.
    assert min(spans) > 0.02


def test_more_threads_than_the_machine_has_are_not_started(mesh):
    rays = np.random.default_rng(1).uniform(-1, 1, (20_000, 6)).astype(mesh.dtype)
    before = threading.active_count(), len(os.listdir("/proc/self/task")) if os.path.isdir("/proc/self/task") else 0
    assert (mesh.closest(rays, threads=1000) == mesh.closest(rays, threads=1)).all()
    if before[1]:
        assert len(os.listdir("/proc/self/task")) - before[1] <= (os.cpu_count() or 1) + 1


def test_the_lock_is_let_go(mesh):
    """Checks that another Python thread makes progress during a query."""
    eye, ways = camera(1200, [1, 2, 3])
    rays = np.concatenate([np.broadcast_to(eye, ways.shape), ways], axis=-1).astype(mesh.dtype)
    turns, done = [0], threading.Event()

    def turn():
        while not done.is_set():
            turns[0] += 1
            time.sleep(0)

    other = threading.Thread(target=turn)
    other.start()
    before = turns[0]
    mesh.all(rays.reshape(-1, 6), threads=1)
    during = turns[0] - before
    done.set()
    other.join()
    assert during > 20


INTERRUPTED = """
import numpy as np, intertri, os, pathlib, pickle, signal, sys, tempfile, threading, time
sys.path.insert(0, {tests!r})
from conftest import icosphere
# A script that runs these tests in the background makes its children ignore the signal.
signal.signal(signal.SIGINT, signal.default_int_handler)
vertices, faces = icosphere({steps})
mesh = intertri.Mesh(vertices.astype(np.float32), faces)
pressed = []
rng = np.random.default_rng(0)
rays = rng.uniform(-1, 1, (8_000_000, 6)).astype(np.float32)
def press():
    pressed.append(time.perf_counter())
    os.kill(os.getpid(), signal.SIGINT)
timer = threading.Timer(0.3, press)
mesh.closest(rays[:10])
def fan(count):
    # All triangles meet in one point.
    turn = np.linspace(0, 2 * np.pi, count, endpoint=False)
    rim = np.stack([np.cos(turn), np.sin(turn), np.ones(count)], axis=1)
    spokes = np.stack([np.zeros(count, int), 1 + np.arange(count), 1 + (np.arange(count) + 1) % count], axis=1)
    return intertri.Mesh(np.concatenate([[[0, 0, 0]], rim]), spokes)
def pile(count):
    # A ray crosses them all.
    return intertri.Mesh(np.float32([[-9, -9, 0], [9, -9, 0], [0, 9, 0]]) + np.float32([0, 0, 1e-4]) * np.arange(count)[:, None, None])
def repeat(call):
    while True:
        call()
{prepare}
timer.start()
try:
    {ask}
except KeyboardInterrupt:
    print("ended", time.perf_counter() - pressed[0])
    assert mesh.closest(rays[:1000]).shape == (1000,)
else:
    print("not heeded")
"""


# Calls that take seconds, each preceded by its setup.
SLOW = {
    "rays": "mesh.closest(rays, threads=THREADS)",
    "rays in float32": "mesh.closest(rays, threads=THREADS, dtype=intertri.HIT32)",
    "lists": "mesh.all(rays, threads=THREADS)",
    "rays at a vertex": "m = fan(1_000_000); tips = np.zeros((200_000, 6)) + [1e-9, 2e-9, 5, 0, 0, -1]; "
                        "GO m.closest(tips, threads=THREADS)",
    "any at a vertex": "m = fan(1_000_000); tips = np.zeros((200_000, 6)) + [1e-9, 2e-9, 5, 0, 0, -1]; "
                       "GO m.any(tips, threads=THREADS)",
    "crossings": "m = pile(100_000); GO m.count_crossings(rays[:20_000, :3] / 9 - np.float32([0, 0, 9]), [0, 0, 1], threads=THREADS)",
    "lists of many": "m = pile(100_000); GO m.all(rays[:2_000, :3] / 9 - np.float32([0, 0, 9]), [0, 0, 1], threads=THREADS)",
    "insides": "m = pile(100_000); GO m.contains(rays[:, :3] - np.float32([4, 4, 9]), assume_closed=True, threads=THREADS)",
    "builds": "GO repeat(lambda: intertri.Mesh(mesh.vertices, mesh.faces, threads=THREADS))",
    "refits": "GO repeat(lambda: mesh.refit(mesh.vertices * np.float32(1.5), threads=THREADS))",
    "closedness": "GO repeat(lambda: setattr(mesh._at, 'is_closed', None) or mesh.is_closed)",
    "pickles": "GO repeat(lambda: pickle.loads(pickle.dumps(mesh)))",
    "reading": "path = pathlib.Path(tempfile.mkdtemp(), 'a.obj'); path.write_text('v 0 0 0\\nv 1 0 0\\nv 0 1 0\\n' + "
               "'f 1 2 3\\n' * 8_000_000); GO intertri.Mesh.read(path, threads=THREADS)",
    # Each of these points is about equally near to every face.
    "few points": "mesh.closest_point(np.float32(rng.normal(size=(444, 3)) * 1e-7), threads=THREADS)",
    "points": "mesh.closest_point(np.float32(rng.normal(size=(9999, 3)) * 1e-7), threads=THREADS)",
}


@pytest.mark.skipif(sys.platform == "win32", reason="no such signal")
@pytest.mark.parametrize("threads", [1, None])
@pytest.mark.parametrize("call", SLOW)
def test_ctrl_c_ends_a_query(call, threads):
    prepare, _, ask = SLOW[call].replace("THREADS", str(threads)).rpartition("GO ")
    steps = 7 if "point" in call else 8 if call in ("builds", "refits", "closedness", "pickles") else 5
    script = INTERRUPTED.format(tests=str(Path(__file__).parent), prepare=prepare, ask=ask, steps=steps)
    out = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=300)
    assert out.stdout.startswith("ended"), out
    # A call usually ends about 0.2 s after Ctrl-C; the limit leaves slack for a busy machine.
    assert float(out.stdout.split()[1]) < 1


@pytest.mark.parametrize("name", ["intertri", "intertri._dtypes", "intertri._mesh", "intertri._triangles",
                                  "intertri._rays", "intertri._points", "intertri._scene", "intertri.trimesh", "intertri.open3d",
                                  "intertri.pyvista", "intertri.dask"])
def test_examples_of_the_documentation(name):
    needs = {"intertri.trimesh": ["trimesh"], "intertri.pyvista": ["pyvista"], "intertri.dask": ["dask.array"]}
    for other in needs.get(name, []):
        pytest.importorskip(other)
    failed, tried = doctest.testmod(importlib.import_module(name))
    assert failed == 0 and (tried or name == "intertri._dtypes")


def test_every_query_has_an_example():
    names = [name for name in dir(intertri.Mesh) if not name.startswith("_")]
    plain = {"vertices", "faces", "dtype", "triangles", "bounds", "is_closed"}
    missing = [name for name in names if name not in plain and ">>>" not in (getattr(intertri.Mesh, name).__doc__ or "")]
    assert len(names) > 10 and not missing


PACKAGE = Path(intertri.__file__).parent
PROJECT = Path(__file__).parent.parent


@pytest.mark.parametrize("checker", [["mypy"], ["pyright"]], ids=["mypy", "pyright"])
def test_types(checker, tmp_path):
    pytest.importorskip(checker[0])
    use = tmp_path / "use.py"
    use.write_text("""\
import intertri
import numpy as np
from numpy.typing import NDArray
mesh = intertri.Mesh(np.zeros((3, 3), np.float32), [[0, 1, 2]])
any_hit: NDArray[np.bool_] = mesh.any([0, 0, 0], [0, 0, 1], mode="certified", threads=2)
faces: NDArray[np.uint32] = mesh.faces
hits: NDArray[np.void] = mesh.closest([[0, 0, 0]], [0, 0, 1], dtype=intertri.HIT32)
lists: intertri.HitLists = mesh.all([[0, 0, 0]], [0, 0, 1])
""")
    wrong = tmp_path / "wrong.py"
    wrong.write_text("""\
import intertri
intertri.Mesh([[0, 0, 0]], [[0, 0, 0]]).any([0, 0, 0], [0, 0, 1], mode="fast")
""")
    # Check only the package itself, not the packages on which it builds, whose type annotations are
    # less complete.
    where = ["--pythonpath", sys.executable] if checker == ["pyright"] else []
    run = lambda *files: subprocess.run([sys.executable, "-m", *checker, *(where if files else []), *map(str, files)],
                                        capture_output=True, text=True, cwd=PROJECT)
    ours = run()
    if "npm" in ours.stderr or "nodeenv" in ours.stderr:
        pytest.skip("pyright is not available here")
    assert ours.returncode == 0, ours.stdout + ours.stderr
    assert run(use).returncode == 0, run(use).stdout
    assert run(wrong).returncode != 0 and "mode" in run(wrong).stdout
