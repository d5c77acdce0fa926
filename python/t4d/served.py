"""Files that fsspec can read (s3://, gs://, sftp://, ...), for programs that read http://.

The program t4d reads parts of files on web servers. Here a process serves to itself what fsspec finds,
so that such inputs can be woven and measured without copying them as a whole.
"""

from __future__ import annotations

import functools
import hashlib
import importlib
import posixpath
import re
import threading
import urllib.parse
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any, Tuple

_URL = re.compile(r"^(--?[^=]+=)?([a-z][a-z0-9+.-]*)://(.*)$", re.DOTALL)


def package(name: str) -> Any:
    """One that is only needed here."""
    return importlib.import_module(name)


class _Handler(BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"

    def _found(self) -> Tuple[Any, str, int]:
        fsspec = package("fsspec")

        scheme, _, rest = urllib.parse.unquote(self.path).lstrip("/").partition("/")
        files, path = fsspec.core.url_to_fs(f"{scheme}://{rest}")
        about = files.info(path)
        if about["type"] != "file":
            raise FileNotFoundError(path)
        return files, path, int(about["size"])

    def _answer(self, with_body: bool) -> None:
        try:
            files, path, size = self._found()
            begin, end = 0, size
            asked = re.fullmatch(r"bytes=(\d*)-(\d*)", self.headers.get("Range", ""))
            if asked and (asked[1] or asked[2]):
                begin = int(asked[1]) if asked[1] else max(0, size - int(asked[2]))
                end = min(size, int(asked[2]) + 1) if asked[1] and asked[2] else size
            if begin >= end and size > 0:
                self.send_response(416)
                self.send_header("Content-Range", f"bytes */{size}")
                self.send_header("Content-Length", "0")
                self.end_headers()
                return
            body = files.cat_file(path, start=begin, end=end) if with_body and end > begin else b""
            self.send_response(206 if asked else 200)
            self.send_header("Content-Length", str(end - begin))
            self.send_header("Accept-Ranges", "bytes")
            self.send_header("ETag", f'"{files.ukey(path)}"')
            if asked:
                self.send_header("Content-Range", f"bytes {begin}-{end - 1}/{size}")
            self.end_headers()
            self.wfile.write(body)
        except (FileNotFoundError, NotADirectoryError, IsADirectoryError):
            self.send_error(404)
        except (OSError, ValueError, ImportError) as error:
            self.send_error(502, type(error).__name__)

    def do_GET(self) -> None:
        self._answer(with_body=True)

    def do_HEAD(self) -> None:
        self._answer(with_body=False)

    def log_message(self, *arguments: Any) -> None:
        pass


@functools.lru_cache(maxsize=1)
def _address() -> str:
    server = ThreadingHTTPServer(("127.0.0.1", 0), _Handler)
    server.daemon_threads = True
    threading.Thread(target=server.serve_forever, daemon=True).start()
    return f"http://127.0.0.1:{server.server_address[1]}"


def readable(word: str, cache: Path) -> str:
    """A word of a command line, with a URL that the program cannot read as one that it can: Zarr and
    .t4d are served in pieces, other files are copied into ``cache``, once."""
    url = _URL.match(word)
    if not url or url[2] in ("http", "https"):
        return word
    option, scheme, rest = url[1] or "", url[2], url[3]
    if ".zarr" in rest or rest.endswith((".t4d", ".t4dm")):
        return f"{option}{_address()}/{scheme}/{urllib.parse.quote(rest)}"
    return f"{option}{_copy(f'{scheme}://{rest}', cache)}"


_copying = threading.Lock()


def _copy(url: str, cache: Path) -> Path:
    fsspec = package("fsspec")

    files, path = fsspec.core.url_to_fs(url)
    version = hashlib.sha256(f"{url} {files.ukey(path)}".encode()).hexdigest()[:16]
    copy = cache / version / posixpath.basename(str(path))
    with _copying:
        if not copy.exists():
            copy.parent.mkdir(parents=True, exist_ok=True)
            part = copy.with_name(f".{copy.name}.part")
            files.get_file(path, str(part))
            part.replace(copy)
    return copy
