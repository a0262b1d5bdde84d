"""Tests that running out of memory raises MemoryError and never aborts. Each call is repeated, each
time with a different allocation failing."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

# A shim in front of the system allocator. After `arm(count)`, the next `count` large allocations
# succeed, and the one after them fails.
FAILING = r"""
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <stdatomic.h>
#include <stddef.h>

static const size_t LEAST = 1 << 20;
static atomic_long left = -1;

void arm(long count) { atomic_store(&left, count); }
int has_failed(void) { return atomic_exchange(&left, -1) < 0; }

static int fails(size_t size) {
    if (size < LEAST || atomic_load(&left) < 0) return 0;
    if (atomic_fetch_sub(&left, 1) != 0) return 0;
    errno = ENOMEM;
    return 1;
}

#define NEXT(name) static typeof(&name) next; if (!next) next = (typeof(&name))dlsym(RTLD_NEXT, #name)
extern void *malloc(size_t), *calloc(size_t, size_t), *realloc(void *, size_t);
extern int posix_memalign(void **, size_t, size_t);

void *malloc(size_t size) { NEXT(malloc); return fails(size) ? 0 : next(size); }
void *realloc(void *memory, size_t size) { NEXT(realloc); return fails(size) ? 0 : next(memory, size); }
int posix_memalign(void **to, size_t align, size_t size) {
    NEXT(posix_memalign);
    return fails(size) ? ENOMEM : next(to, align, size);
}
extern void *__libc_calloc(size_t, size_t);
void *calloc(size_t count, size_t size) { return fails(count * size) ? 0 : __libc_calloc(count, size); }
extern void *mmap(void *, size_t, int, int, int, long);
void *mmap(void *at, size_t size, int access, int flags, int file, long offset) {
    NEXT(mmap);
    return fails(size) ? (void *)-1 : next(at, size, access, flags, file, offset);
}
void *mmap64(void *at, size_t size, int access, int flags, int file, long offset) {
    return mmap(at, size, access, flags, file, offset);
}
"""

SCRIPT = """
import ctypes, pathlib, pickle, sys, tempfile, threading
import numpy as np, intertri
sys.path.insert(0, {tests!r})
from conftest import icosphere
shim = ctypes.CDLL(None)
dtype, threads = np.dtype({dtype!r}), {threads}
vertices, faces = icosphere(6)
vertices = vertices.astype(dtype)
rng = np.random.default_rng(0)
rays = rng.uniform(-2, 2, (100_000, 6)).astype(dtype)
points = np.ascontiguousarray(rays[:, :3])
mesh = intertri.Mesh(vertices, faces)
scene = intertri.Scene([mesh, mesh])
folder = tempfile.TemporaryDirectory()
path = pathlib.Path(folder.name, "a.obj")
path.write_text("".join("v %r %r %r\\n" % tuple(map(float, v)) for v in vertices) +
                "".join("f %d %d %d\\n" % tuple(f + 1) for f in faces))

def refit_beside_a_query():
    moving = intertri.Mesh(vertices, faces)
    query = threading.Thread(target=moving.closest, args=[rays], kwargs=dict(threads=1))
    query.start()
    try:
        moving.refit(vertices * dtype.type(2))
        return moving.closest(rays[:1000])
    finally:
        query.join()

def is_closed():
    mesh._at.is_closed = None
    return np.array(mesh.is_closed)

calls = {{
    "build": lambda: intertri.Mesh(vertices, faces, threads=threads).closest(rays[:1000]),
    "read": lambda: intertri.Mesh.read(path).closest(rays[:1000]),
    "pickle": lambda: pickle.loads(pickle.dumps(mesh)).closest(rays[:1000]),
    "scene": lambda: pickle.loads(pickle.dumps(scene)).closest(rays[:1000]),
    "refit": lambda: (mesh.refit(vertices), mesh.closest(rays[:1000]))[1],
    "refit beside a query": refit_beside_a_query,
    "closest": lambda: mesh.closest(rays, threads=threads),
    "closest_triangle": lambda: mesh.closest_triangle(rays, threads=threads),
    "any": lambda: mesh.any(rays, threads=threads),
    "all": lambda: mesh.all(rays, threads=threads).hits,
    "crossings": lambda: mesh.crossings(rays, threads=threads).hits,
    "count_crossings": lambda: mesh.count_crossings(rays, threads=threads),
    "visible": lambda: mesh.visible(points, points[::-1], threads=threads),
    "spawn_rays": lambda: mesh.spawn_rays(mesh.closest(rays), points, threads=threads),
    "is_closed": is_closed,
    "contains": lambda: mesh.contains(points, threads=threads),
    "winding_number": lambda: mesh.winding_number(points, threads=threads),
    "closest_point": lambda: mesh.closest_point(points[:20_000], threads=threads),
    "signed_distance": lambda: mesh.signed_distance(points[:20_000], threads=threads),
}}
errors = 0
for name, call in calls.items():
    truth = call().tobytes()
    for count in range(10_000):
        print(name, count, flush=True)
        intertri._memory._idle.clear()
        shim.arm(count)
        try:
            answer = call()
        except MemoryError:
            answer = None
        failed = shim.has_failed()
        assert failed or answer is not None, "MemoryError for no reason"
        assert answer is None or answer.tobytes() == truth, "wrong result"
        errors += answer is None
        if not failed:
            break
assert errors > 30, errors
"""


@pytest.mark.skipif(not sys.platform.startswith("linux") or not shutil.which("cc"), reason="needs Linux and a C compiler")
@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize("dtype", ["f4", "f8"])
def test_no_allocation_that_fails_aborts(dtype, threads, tmp_path):
    (tmp_path / "failing.c").write_text(FAILING)
    subprocess.run(["cc", "-O1", "-shared", "-fPIC", "-o", tmp_path / "failing.so", tmp_path / "failing.c", "-ldl"], check=True)
    script = SCRIPT.format(tests=str(Path(__file__).parent), dtype=dtype, threads=threads)
    out = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=600,
                         env=os.environ | {"LD_PRELOAD": str(tmp_path / "failing.so")})
    assert out.returncode == 0, (out.stdout.splitlines()[-1:], out.stderr[-2000:])
