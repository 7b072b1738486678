# The page of a run under way, served to this machine alone; it reads what the run writes and
# nothing else.
# SPDX-License-Identifier: BSD-3-Clause
import errno
import hashlib
import http.server
import json
import os
import sys
import threading
import time

from report_bodies import Bodies, newest_snapshot
from report_page import data_of, details, lead, name_of, page, series_of, summary
from report_run import Run

PAUSE = 2  # s: files are not looked at more often, whoever asks


class Watched:
    """The run as it was when its files were last looked at, and what was packed of it."""

    def __init__(self, folder):
        self.run = Run(folder, "spall watch")
        self.lock = threading.Lock()
        self.looked, self.identity = -PAUSE, None
        self.packed = {}  # number of a snapshot: its text
        self.look()

    def look(self):
        if time.monotonic() - self.looked < PAUSE:
            return
        self.run.update()
        first = os.path.join(self.run.folder, "snapshots", self.run.snapshots()[0])
        with newest_snapshot(self.run) as file:
            count = len(file["particles/all/radius"])
        # Places are rounded alike in all snapshots. A run that is begun again, or has more bodies,
        # wants a new page.
        identity = f"{os.stat(first).st_mtime_ns} {count}"
        if identity != self.identity:
            self.identity, self.packed, self.bodies = identity, {}, Bodies(self.run)
        self.shown = self.bodies.shown(self.run)
        self.packed = {number: text for number, text in self.packed.items() if number in self.shown}
        self.words = {"lead": lead(self.run), "summary": summary(self.run),
                      "details": details(self.run)}
        self.looked = time.monotonic()

    def answer(self, path):
        """The kind and the text of an answer; None where there is nothing of that name."""
        if path == "/":
            return "text/html", page([self.run],
                                     [data_of(self.run, name_of(self.run, [self.run]), self.bodies,
                                              [])], live=True)
        name = path[1:]
        if name == "state":
            stamp = hashlib.sha256(json.dumps(self.words).encode()).hexdigest()
            value = {"over": bool(self.run.results) and not self.run.under_way,
                     "identity": self.identity,
                     "rows": len(self.run.series["time"]), "shown": self.shown, "words": stamp}
        elif name == "series":
            value = series_of(self.run)
        elif name == "words":
            value = self.words
        elif name.startswith("snapshots/") and name[10:].isdecimal() and int(
            name[10:]) in self.shown:
            number = int(name[10:])
            if number not in self.packed and (frame := self.bodies.frame(number)):
                self.packed[number] = json.dumps(frame, allow_nan=False)
            return "application/json", self.packed.get(number, "null")
        else:
            return None
        return "application/json", json.dumps(value, allow_nan=False)


class Handler(http.server.BaseHTTPRequestHandler):
    def do_GET(self):
        watched = self.server.watched
        try:
            with watched.lock:
                watched.look()
                found = watched.answer(self.path)
        # A run that is begun again has nothing for a moment.
        except (SystemExit, OSError, KeyError, ValueError) as error:
            self.send_error(503, str(error))
            return
        if not found:
            self.send_error(404)
            return
        kind, text = found
        body = text.encode()
        self.send_response(200)
        self.send_header("Content-Type", f"{kind}; charset=utf-8")
        self.send_header("Content-Length", str(len(body)))
        self.send_header("Cache-Control", "no-store")
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, *_):
        pass


def serve(folder, port):
    os.nice(19)  # the run comes first
    watched = Watched(folder)
    try:
        server = http.server.ThreadingHTTPServer(("127.0.0.1", port), Handler)
    except OSError as error:
        if error.errno != errno.EADDRINUSE:
            sys.exit(f"spall watch: port {port}: {error.strerror}")
        sys.exit(f"spall watch: port {port} is taken: choose another with --port")
    server.watched, server.daemon_threads = watched, True
    try:  # Ctrl-C may come as soon as somebody can read the address
        print(f"http://127.0.0.1:{server.server_port}/ shows '{folder}'; Ctrl-C ends this",
              flush=True)
        server.serve_forever()
    except KeyboardInterrupt:
        print()
