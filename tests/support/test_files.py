"""Files are read up to a bound and written atomically."""

import io
import os
import zipfile

import pytest

from aerodrake.support.errors import BadInput
from aerodrake.support.files import check_stored_zip, leaves_package, read_bounded, write_atomically


def names(folder) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def test_reads_a_file_up_to_the_bound(tmp_path):
    path = tmp_path / "a"
    path.write_bytes(b"12345")
    assert read_bounded(path, 5) == b"12345"
    with pytest.raises(BadInput, match="a: expected at most 4 bytes"):
        read_bounded(path, 4)


@pytest.mark.parametrize("name, reason", [("none", "No such file"), (".", "Is a directory")])
def test_an_unreadable_file_is_named(tmp_path, name, reason):
    with pytest.raises(BadInput, match=f"expected a readable file: {reason}"):
        read_bounded(tmp_path / name, 5)


def test_pipes_and_devices_are_refused(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    for path in (tmp_path / "pipe", "/dev/zero"):
        with pytest.raises(BadInput, match="expected a file, got a pipe or a device"):
            read_bounded(path, 5)


@pytest.mark.parametrize(
    "uri",
    [
        "package://other/x",
        "package://aerodrake/../x",
        "package://aerodrake//etc/passwd",
        "package://aerodrake/",
        "package://",
    ],
)
def test_uris_that_leave_the_package(uri):
    assert leaves_package(uri) and not leaves_package("package://aerodrake/robots/x.urdf")


def archive(method=zipfile.ZIP_STORED, more=0):
    """Returns a zip archive with one file, whose entry is repeated in the directory."""
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w", method) as file:
        file.writestr("a", "0" * 1000)
        for _ in range(more):
            file.filelist.append(file.filelist[0])
        file._didModify = True
    return content.getvalue()


DAMAGED = archive()[:500] + b"1" + archive()[501:]


def test_an_intact_zip_archive_is_accepted():
    check_stored_zip(archive())


@pytest.mark.parametrize(
    ("content", "expected"),
    [
        (b"", "an empty file"),
        (b"t,x,y,z", "another or a truncated file"),
        (archive()[:-20], "another or a truncated file"),
        (archive(zipfile.ZIP_DEFLATED), "a compressed file"),
        (archive(more=10), "a compressed file"),
        (DAMAGED, "a damaged file"),
        (archive().replace(b"PK\x03\x04", b"PK\x03\x05"), "a damaged file"),
    ],
)
def test_other_contents_are_named(content, expected):
    with pytest.raises(ValueError, match=f"^{expected}$"):
        check_stored_zip(content)


def test_writing_preserves_the_mode_and_links(tmp_path):
    path, link = tmp_path / "a", tmp_path / "b"
    path.write_bytes(b"old")
    path.chmod(0o640)
    link.symlink_to(path)
    write_atomically(link, b"new")
    assert path.read_bytes() == b"new" and link.is_symlink()
    assert path.stat().st_mode & 0o777 == 0o640
    assert names(tmp_path) == ["a", "b"]


def test_a_new_file_has_the_default_mode(tmp_path):
    (tmp_path / "usual").write_bytes(b"")
    write_atomically(tmp_path / "new", b"")
    modes = [(tmp_path / name).stat().st_mode for name in ("usual", "new")]
    assert modes[0] == modes[1]


def test_a_failed_write_leaves_the_old_file(tmp_path, monkeypatch):
    path = tmp_path / "a"
    path.write_bytes(b"old")

    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "replace", full)
    with pytest.raises(BadInput, match="a: cannot be written: No space left on device"):
        write_atomically(path, b"new")
    assert path.read_bytes() == b"old" and names(tmp_path) == ["a"]
