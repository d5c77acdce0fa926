#!/usr/bin/env python3
"""A web server for the tests: it serves the files of a folder, well or with a fault.

    web_server.py FOLDER

Prints its port. A request for /FAULT/FILE is answered with that fault (see the table at the end);
/plain/FILE has none. Appends to FOLDER/requests.jsonl a line for each request: its path, Range and
If-Match, the status and how many bytes of the file were sent.
"""
import base64
import hashlib
import http.server
import json
import pathlib
import re
import sys
import threading
import time

folder = pathlib.Path(sys.argv[1])
log = open(folder / 'requests.jsonl', 'a', encoding='utf-8')
served = {}  # requests so far, by path
lock = threading.Lock()


class Answer:
    """A part of a file, or all of it if nothing is wanted, with the fields of its header; a fault
    changes one of them."""

    def __init__(self, content, wanted):
        self.content = content
        first, last = re.fullmatch(r'bytes=(\d*)-(\d*)', wanted or 'bytes=0-').groups()
        size = len(content)
        self.first = int(first) if first else max(0, size - int(last))
        self.end = min(size, int(last) + 1) if first and last else size
        self.total = size
        self.body = content[self.first:self.end]
        self.status = 206 if wanted else 200
        self.etag = '"' + hashlib.sha1(content).hexdigest() + '"'
        self.modified = 'Sat, 01 Jan 2022 00:00:00 GMT'
        self.range = None       # instead of the true Content-Range
        self.length = None      # instead of the true Content-Length
        self.encoding = None
        self.sent = None        # bytes after which the connection breaks

    def content_range(self):
        if self.range is not None:
            return self.range
        return f'bytes {self.first}-{self.end - 1}/{self.total}'


class Handler(http.server.BaseHTTPRequestHandler):
    protocol_version = 'HTTP/1.1'

    def log_message(self, *_):
        pass

    def note(self, status, sent):
        with lock:
            entry = {'path': self.path, 'range': self.headers.get('Range', ''),
                     'match': self.headers.get('If-Match', ''), 'status': status, 'bytes': sent}
            print(json.dumps(entry), file=log, flush=True)

    def refuse(self, status, **fields):
        self.note(status, 0)
        self.send_response(status)
        for name, value in fields.items():
            self.send_header(name, value)
        self.send_header('Content-Length', '0')
        self.end_headers()

    def send_without_end(self, content, status=200, **fields):
        self.note(status, len(content))
        self.send_response(status)
        for name, value in fields.items():
            self.send_header(name, value)
        self.send_header('Content-Length', str(2**40))
        self.end_headers()
        try:
            while True:
                self.wfile.write(content)
        except OSError:
            self.close_connection = True

    def trickle(self, content, seconds):
        """A byte at a time."""
        try:
            for i in range(len(content)):
                self.wfile.write(content[i:i + 1])
                time.sleep(seconds)
        except OSError:
            pass
        self.close_connection = True

    def do_GET(self):
        _, fault, name = self.path.partition('?')[0].split('/', 2)
        with lock:
            before = served.get(self.path, 0)
            served[self.path] = before + 1
        if fault.startswith('status-'):
            # status-404, or of the names with a part alone: status-404@part
            status, at, part = fault.removeprefix('status-').partition('@')
            if not at or part in name.split('/'):
                return self.refuse(int(status))
        if fault == 'redirect':
            return self.refuse(302, Location=f'/plain/{name}')
        if fault == 'redirect-for-ever':
            return self.refuse(302, Location=self.path)
        if fault == 'redirect-without-end':
            return self.send_without_end(bytes(1 << 16), 302, Location=f'/plain/{name}')
        if fault == 'trickle-header':
            self.note(206, 0)
            return self.trickle(b'HTTP/1.1 206 Partial Content\r\nX: ' + b'x' * 1000, 0.1)
        if fault in ('long-header', 'long-header-line'):
            # Of many lines, or of one that never ends.
            break_ = b'\r\n' if fault == 'long-header' else b''
            self.note(206, 0)
            self.wfile.write(b'HTTP/1.1 206 Partial Content\r\n')
            try:
                for _ in range(10000):
                    self.wfile.write(b'X: ' + b'x' * 1000 + break_)
            except OSError:
                pass
            self.close_connection = True
            return None
        if fault == 'redirect-to-file':
            return self.refuse(302, Location='file:///etc/hostname')
        if fault == 'login':
            given = self.headers.get('Authorization', '')
            if given != 'Basic ' + base64.b64encode(b'user:secret').decode():
                return self.refuse(401)
        path = folder / name
        if not path.is_file():
            return self.refuse(404)
        content = path.read_bytes()
        answer = Answer(content, self.headers['Range'])
        alter = FAULTS.get(fault)
        if alter:
            alter(answer, before)
        match = self.headers.get('If-Match')
        if match and match != answer.etag and fault != 'etag-ignored':
            return self.refuse(412)
        if fault == 'whole':
            return self.send_without_end(content)
        length = len(answer.body) if answer.length is None else answer.length
        body = answer.body if answer.sent is None else answer.body[:answer.sent]
        self.note(answer.status, len(body))
        self.send_response(answer.status)
        range_sent = answer.content_range() if answer.status == 206 else None
        for field, value in (('Content-Range', range_sent), ('ETag', answer.etag),
                             ('Last-Modified', answer.modified),
                             ('Content-Encoding', answer.encoding)):
            if value:
                self.send_header({'lower-case': field.lower(), 'upper-case': field.upper()}.get(
                    fault, field), value)
        self.send_header('Content-Length', str(length))
        self.end_headers()
        if fault == 'trickle':
            return self.trickle(body, 0.1)
        try:
            self.wfile.write(body)
        except OSError:
            pass
        if fault == 'stall':
            time.sleep(600)
        if length != len(body):
            self.close_connection = True


def half(answer):
    answer.sent = len(answer.body) // 2


def no_names(answer):
    answer.etag = answer.modified = None


def changed(answer):
    """As if another file of the same length had been put in its place."""
    answer.body = bytes(byte ^ 0x55 for byte in answer.body)


def set_(name, value):
    return lambda answer, before: setattr(answer, name, value)


def later(alter):
    """From the second request on."""
    return lambda answer, before: alter(answer) if before > 0 else None


def without_names(alter):
    return lambda answer, before: (no_names(answer), alter(answer, before))


FAULTS = {
    'no-etag': lambda answer, before: no_names(answer),
    'weak-etag': lambda answer, before: setattr(answer, 'etag', 'W/' + answer.etag),
    'changed': later(lambda answer: setattr(answer, 'etag', '"another"')),
    'etag-ignored': later(lambda answer: setattr(answer, 'etag', '"another"')),
    'time-changed': lambda answer, before: (
        setattr(answer, 'etag', None),
        setattr(answer, 'modified', f'Sat, 01 Jan 2022 00:00:0{min(before, 9)} GMT')),
    'length-changed': without_names(later(lambda answer: setattr(answer, 'total', answer.total + 8))),
    'changed-unnoticed': without_names(later(changed)),
    'dropped-once': lambda answer, before: half(answer) if before % 2 == 0 else None,
    'dropped': lambda answer, before: half(answer),
    'dropped-later': later(half),
    'short': lambda answer, before: setattr(answer, 'body', answer.body[:-8]),
    'long': lambda answer, before: setattr(answer, 'body', answer.body + bytes(8)),
    'fewer': lambda answer, before: (setattr(answer, 'body', answer.body[:-8]),
                                     setattr(answer, 'end', answer.end - 8)),
    'shifted': later(lambda answer: (setattr(answer, 'first', answer.first + 1),
                                     setattr(answer, 'end', answer.end + 1))),
    'no-range': set_('range', ''),
    'nonsense': set_('range', 'bytes \x1b[31m/x'),
    'total-unknown': lambda answer, before: setattr(
        answer, 'range', f'bytes {answer.first}-{answer.end - 1}/*'),
    'total-false': lambda answer, before: (
        setattr(answer, 'first', answer.first + 2**40), setattr(answer, 'end', answer.end + 2**40),
        setattr(answer, 'total', answer.total + 2**40)),
    'zipped': set_('encoding', 'gzip'),
    'stall': set_('sent', 8),
}

http.server.ThreadingHTTPServer.request_queue_size = 128  # many connect at once
server = http.server.ThreadingHTTPServer(('127.0.0.1', 0), Handler)
print(server.server_address[1], flush=True)
server.serve_forever()
