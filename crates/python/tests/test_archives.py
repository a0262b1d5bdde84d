"""Tests that files and pickles either restore the mesh that was saved or are rejected."""

import copy
import io
import pickle
import zipfile

import intertri
import numpy as np
import pytest
from conftest import box, icosphere

MEMBERS = ["vertices", "faces", "tree"]


def sphere(dtype, move=0.0, steps=1):
    vertices, faces = icosphere(steps)
    return intertri.Mesh((vertices + move).astype(dtype), faces)


def members_of(mesh, folder):
    mesh.save(folder / "one.npz")
    with zipfile.ZipFile(folder / "one.npz") as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def archive_of(members):
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w") as archive:
        for name, content in members.items():
            archive.writestr(name, content)
    return file.getvalue()


def answers(mesh):
    """Returns the answers of a mesh for random rays, and the answers of a new mesh with the same
    vertices and faces."""
    rays = np.random.default_rng(5).uniform(-2, 2, (200, 6)).astype(mesh.dtype)
    new = intertri.Mesh(mesh.vertices, mesh.faces)
    return mesh.closest(rays), new.closest(rays)


def load_or_refuse(path, content):
    """Loads a mesh whose answers match its arrays, or returns None after a one-line error."""
    path.write_bytes(content)
    try:
        mesh = intertri.load(path)
    except ValueError as error:
        assert "\n" not in str(error) and str(path) in str(error), error
        return None
    ours, new = answers(mesh)
    assert (ours == new).all()
    return mesh


def test_members_of_two_archives_do_not_mix(dtype, tmp_path):
    one, other = (members_of(sphere(dtype, move), tmp_path) for move in (0, 0.25))
    assert set(one) > {f"{name}.npy" for name in MEMBERS} and list(one) == list(other)
    for choice in range(2 ** len(one)):
        mixed = {name: (one, other)[choice >> k & 1][name] for k, name in enumerate(one)}
        mesh = load_or_refuse(tmp_path / "mixed.npz", archive_of(mixed))
        # Both archives have the same faces, so only the other members differ.
        distinct = {mixed[name] == one[name] for name in one if one[name] != other[name]}
        assert (mesh is None) == (len(distinct) > 1)


@pytest.mark.filterwarnings("ignore:Reading")
def test_altered_members_are_refused(dtype, tmp_path):
    """Alters, truncates, or extends the contents of members, but keeps the archive's own checksums
    consistent."""
    members = members_of(sphere(dtype, steps=0), tmp_path)
    tried = 0
    for name, content in members.items():
        for at in {*range(200), *range(0, len(content), 61)} & {*range(len(content))}:
            for flip in (1, 0x80, 0x55):
                changed = content[:at] + bytes([content[at] ^ flip]) + content[at + 1:]
                mesh = load_or_refuse(tmp_path / "altered.npz", archive_of(members | {name: changed}))
                # Some bytes of a member's header are padding.
                assert mesh is None or at < 128 and mesh.digest == sphere(dtype, steps=0).digest
                tried += 1
        for cut in range(0, len(content), 97):
            for changed in (content[:cut], content + content[:cut + 1]):
                assert load_or_refuse(tmp_path / "altered.npz", archive_of(members | {name: changed})) is None
                tried += 1
    assert tried > 2000


def test_other_vertices_of_the_same_number_are_refused(dtype, tmp_path):
    """Loads well-formed archives whose tree belongs to other vertices or faces."""
    mesh, path = sphere(dtype), tmp_path / "mesh.npz"
    mesh.save(path)
    with np.load(path) as saved:
        arrays = dict(saved)
    nudged = arrays["vertices"].copy()
    nudged[7, 1] = np.nextafter(nudged[7, 1], dtype(9))
    swapped = arrays["faces"].copy()
    swapped[[3, 4]] = swapped[[4, 3]]
    for change in [{"vertices": nudged}, {"faces": swapped}, {"vertices": -arrays["vertices"]},
                   {"vertices": np.asfortranarray(arrays["vertices"] * 2)}]:
        np.savez(path, **(arrays | change))
        with pytest.raises(ValueError, match="belong together"):
            intertri.load(path)
    np.savez(path, **(arrays | {"vertices": np.asfortranarray(arrays["vertices"])}))
    assert intertri.load(path).digest == mesh.digest
    np.savez_compressed(path, **arrays)
    assert intertri.load(path).digest == mesh.digest


def test_damaged_archives_are_value_errors(dtype, tmp_path):
    """Covers files truncated to various lengths, files with one changed byte, and files that are
    not archives."""
    mesh, path = sphere(dtype, steps=0), tmp_path / "mesh.npz"
    mesh.save(path)
    whole = path.read_bytes()
    tree = mesh._saved()[2]
    begin = whole.index(tree)
    end = begin + len(tree)
    damaged = [whole[:cut] for cut in range(0, len(whole), 7)]
    for at in [*range(begin), *range(begin, end, 61), *range(end, len(whole))]:
        damaged += [whole[:at] + bytes([whole[at] ^ flip]) + whole[at + 1:] for flip in (1, 0x40, 0xff)]
    damaged += [b"", b"PK", b"\x80\x04N.", pickle.dumps(mesh), b"\x93NUMPY", bytes(1000), whole[::-1]]
    refused = sum(load_or_refuse(path, content) is None for content in damaged)
    assert refused > len(damaged) / 2


def test_a_header_does_not_size_an_allocation(tmp_path):
    """Loads an archive whose header claims 240 TB of vertices."""
    members = members_of(sphere(np.float32), tmp_path)
    header = io.BytesIO()
    np.lib.format.write_array_header_1_0(header, {"descr": "<f4", "fortran_order": False, "shape": (2 * 10**13, 3)})
    content = header.getvalue() + members["vertices.npy"][128:]
    assert load_or_refuse(tmp_path / "large.npz", archive_of(members | {"vertices.npy": content})) is None


def test_files_that_cannot_be_read_are_os_errors(tmp_path):
    for path in (tmp_path / "nothing.npz", tmp_path):
        with pytest.raises(OSError):
            intertri.load(path)


def test_archives_of_before_say_what_to_do(dtype, tmp_path):
    mesh, path = sphere(dtype), tmp_path / "mesh.npz"
    vertices, faces, tree = mesh._saved()[:3]
    np.savez(path, vertices=vertices, faces=faces, tree=np.frombuffer(tree, np.uint8))
    with pytest.raises(ValueError, match="older version.*Mesh.*save") as raised:
        intertri.load(path)
    assert "\n" not in str(raised.value)
    from intertri import _mesh

    with pytest.raises(ValueError, match="older version"):
        _mesh._restore(vertices, faces, tree)


def test_pickles_of_other_vertices_are_refused(dtype):
    one, other = sphere(dtype), sphere(dtype, 0.25)
    restore, (cls, *parts) = one.__reduce__()[:2]
    parts_of_other = other.__reduce__()[1][1:]
    assert restore(cls, *parts).digest == one.digest
    for choice in range(1, 2 ** len(parts) - 1):
        mixed = [(parts, parts_of_other)[choice >> k & 1][k] for k in range(len(parts))]
        alike = lambda a: all(np.array_equal(x, y) for x, y in zip(mixed, a))
        if alike(parts) or alike(parts_of_other):
            continue
        with pytest.raises(ValueError, match="belong together"):
            restore(cls, *mixed)
    # Change bytes in a pickle's arrays and tree.
    whole = pickle.dumps(one, 5)
    for part in (one.vertices.tobytes(), one.faces.tobytes(), parts[2]):
        begin = whole.index(part)
        for at in range(begin, begin + len(part), 97):
            with pytest.raises(ValueError, match="belong together"):
                pickle.loads(whole[:at] + bytes([whole[at] ^ 4]) + whole[at + 1:])


class Named(intertri.Mesh):
    """A mesh with a name."""

    def __init__(self, *args, name):
        super().__init__(*args)
        self.name = name


def test_copies_keep_their_class():
    mesh = Named(*box(), name="box")
    for other in [copy.copy(mesh), copy.deepcopy(mesh), pickle.loads(pickle.dumps(mesh))]:
        assert type(other) is Named and other.name == "box" and other.contains([0, 0, 0])
