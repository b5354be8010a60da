#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Sends bad HTTP conversations to a running daemon: several connections at once, pipelined requests, cuts at any byte,
bodies of every framing, headers that are doubled, folded or endless, changed bytes, and connections closed or reset at
any moment. Each answer must be HTTP with a status that docs/reference/openapi.json lists. The daemon must survive and
have no more memory, files or threads than before. In a daemon built with sanitizers, any finding is a failure.

  fault_injection/conversations.py MULTUM_DRILL [--seconds 60 | --conversations 1000] [--seed N]
"""
import argparse
import collections
import os
import random
import re
import select
import socket
import struct
import sys
import tempfile
import time

sys.path.insert(0, os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
from fuzz import Fuzzer  # noqa: E402
from openapi_check import OpenapiCheck  # noqa: E402
from service_harness import Service, fail, process_state, with_drill  # noqa: E402

STATUSES = {100, 200, 201, 202, 206, 304, 400, 401, 403, 404, 405, 408, 409, 413, 416, 431, 501, 503, 507}
HEADERS = (b"Host: localhost", b"Host: evil", b"Host:", b"Origin: http://localhost", b"Origin: null",
           b"Expect: 100-continue", b"Connection: close", b"Connection: keep-alive", b"Connection: Upgrade",
           b"Upgrade: h2c", b"Content-Length: 0", b"Content-Length: 5", b"Content-Length: -1",
           b"Content-Length: 99999999999999999999",
           b"Content-Length: 4294967297", b"Transfer-Encoding: chunked", b"Transfer-Encoding: identity",
           b"Transfer-Encoding: chunked, chunked", b"Transfer-Encoding : chunked", b"Last-Event-ID: 7",
           b"Last-Event-ID: -9223372036854775809", b"If-None-Match: *", b"Sec-Fetch-Site: cross-site", b"A: b\r\n c",
           b"\xff\xfe: \x80\x9b", b"A" * 4000 + b": b", b"Authorization: Bearer x", b"Range: bytes=0-", b"Cookie: a=b",
           b": empty", b"no colon")
FOUND = re.compile(r"ERROR: AddressSanitizer|runtime error:|WARNING: ThreadSanitizer|LeakSanitizer|unexpected: .*")


class Conversation:
    """Returns the bytes of some pipelined requests, and the pieces in which they are sent."""

    def __init__(self, fuzzer, jobs):
        self.fuzzer, self.random = fuzzer, fuzzer.random
        requests = [self.request(jobs) for _ in range(self.random.choice((1, 1, 1, 2, 3, 8)))]
        data = b"".join(requests)
        if self.random.random() < 0.25:
            data = self.mutated(data)
        self.pieces = self.cut(data)

    def request(self, jobs):
        choose = self.random
        if choose.random() < 0.03:
            return choose.randbytes(choose.choice((1, 10, 500, 20000)))
        method, target, body, _ = self.fuzzer.next(jobs)
        if choose.random() < 0.05:
            method, target, body = "GET", choose.choice(("/v1/events", "/v1/jobs/1/events")), None
        if choose.random() < 0.05:
            method = "HEAD"
        if choose.random() < 0.1:
            method, target, body = "PUT", "/v1/uploads/a.bin", choose.randbytes(choose.choice((0, 1, 5000, 300000)))
        version = choose.choice((b"1.1",) * 12 + (b"1.0", b"2.0", b"0.9"))
        lines = [method.encode() + b" " + target.encode("utf-8", "replace") + b" HTTP/" + version]
        if choose.random() < 0.95:
            lines.append(b"Host: localhost")
        for _ in range(choose.choice((0, 0, 0, 0, 1, 3))):
            lines.append(choose.choice(HEADERS))
        if body is None:
            return b"\r\n".join(lines) + b"\r\n\r\n"
        if choose.random() < 0.4:
            lines.append(b"Transfer-Encoding: chunked")
            body = self.chunked(body)
        else:
            length = len(body) if choose.random() < 0.9 else choose.choice((0, 1, len(body) + 1, len(body) * 2))
            lines.append(b"Content-Length: %d" % length)
        return b"\r\n".join(lines) + b"\r\n\r\n" + body

    def chunked(self, body):
        choose = self.random
        text = b""
        while body:
            size = choose.choice((1, 2, 100, len(body)))
            piece, body = body[:size], body[size:]
            extension = choose.choice((b"",) * 8 + (b";a=b", b';q="x y"', b";" + b"e" * 3000, b" "))
            said = b"%x" % len(piece)
            if choose.random() < 0.03:
                said = choose.choice((b"ffffffffffffffff", b"-1", b"", b"g"))
            text += said + extension + b"\r\n" + piece + (b"\r\n" if choose.random() < 0.98 else b"")
        trailer = choose.choice((b"",) * 6 + (b"A: b\r\n", b"Host: evil\r\n", b"Content-Length: 3\r\n",
                                              b"T: " + b"x" * 20000 + b"\r\n"))
        return text + choose.choice((b"0\r\n",) * 9 + (b"0", b"00000\r\n")) + trailer + b"\r\n"

    def mutated(self, data):
        choose = self.random
        for _ in range(choose.choice((1, 2, 5))):
            if not data:
                break
            at = choose.randrange(len(data))
            what = choose.randrange(5)
            if what == 0:
                data = data[:at] + bytes([choose.randrange(256)]) + data[at + 1:]
            elif what == 1:
                data = data[:at] + data[at + choose.choice((1, 2, 30)):]
            elif what == 2:
                data = data[:at] + choose.choice((b"\r\n", b"\n", b"\r", b"\0", b" ", b"%00", b"\xc2\x9b")) + data[at:]
            elif what == 3:
                data = data[:at] + data[max(0, at - 50):at] * 3 + data[at:]
            else:
                data = data[:at]
        return data

    def cut(self, data):
        choose = self.random
        if choose.random() < 0.5 or len(data) < 2:
            return [data]
        cuts = sorted(choose.randrange(len(data)) for _ in range(choose.choice((1, 2, 10))))
        return [data[a:b] for a, b in zip([0] + cuts, cuts + [len(data)])]


class Line:
    """Holds one connection and its conversation."""

    def __init__(self, port, conversation, choose):
        self.socket = socket.create_connection(("127.0.0.1", port))
        self.socket.setblocking(False)
        self.pieces, self.choose = list(conversation.pieces), choose
        self.sent, self.heard, self.is_done = b"".join(conversation.pieces), b"", False
        self.patience = time.monotonic() + choose.choice((0.02, 0.1, 0.3))

    def step(self):
        try:
            if select.select([self.socket], [], [], 0)[0]:
                piece = self.socket.recv(1 << 20)
                self.is_done = not piece
                self.heard += piece
            if self.pieces:
                count = self.socket.send(self.pieces[0]) if self.pieces[0] else 0
                self.pieces[0] = self.pieces[0][count:]
                if not self.pieces[0]:
                    self.pieces.pop(0)
                    if self.choose.random() < 0.03:
                        self.socket.shutdown(socket.SHUT_WR)
                        self.pieces = []
        except BlockingIOError:
            pass
        except OSError:
            self.is_done = True
        if time.monotonic() > self.patience or (self.choose.random() < 0.002):
            self.is_done = True

    def close(self):
        if self.choose.random() < 0.2:  # a reset
            self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        self.socket.close()


def check_answers(line, statuses):
    """Checks every answer that the connection has received. Bodies are skipped by their length."""
    rest = line.heard
    while rest:
        if len(rest) < 12:
            return
        if not rest.startswith(b"HTTP/1."):
            fail(f"no HTTP: {rest[:200]!r} to {line.sent[:2000]!r}")
        head, separator, after = rest.partition(b"\r\n\r\n")
        status = int(rest[9:12])
        statuses[status] += 1
        if status not in STATUSES:
            fail(f"status {status} to {line.sent[:2000]!r}: {rest[:500]!r}")
        length = re.search(rb"\r\nContent-Length: (\d+)", head)
        if not separator or status == 304 or b"text/event-stream" in head or b"HEAD " in line.sent:
            return
        rest = after[int(length.group(1)) if length else 0:]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("multum")
    parser.add_argument("--seconds", type=float)
    parser.add_argument("--conversations", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=random.SystemRandom().randrange(10**6))
    parser.add_argument("--memory-growth-max", type=int, default=16, help="MiB; sanitizers keep more")
    options = parser.parse_args()
    print(f"seed {options.seed}", flush=True)
    with tempfile.TemporaryDirectory() as folder:
        service = Service(options.multum, folder, config='connections_max = 64\nrequest_memory_max = "16M"\n'
                          'data_max = "64M"\n[[queue]]\nname = "default"\npaused = true\n').start()
        check = OpenapiCheck(with_drill(service.ask("GET", "/openapi.json")[1], service.ask("GET", "/v1/types")[1]))
        fuzzer = Fuzzer(check.document, check, options.seed)
        choose, statuses, count, before = fuzzer.random, collections.Counter(), 0, None
        begun = last = time.monotonic()

        def share_done():
            return (time.monotonic() - begun) / options.seconds if options.seconds else count / options.conversations

        lines = []
        while share_done() < 1:
            while len(lines) < 12:
                lines.append(Line(service.port, Conversation(fuzzer, 20), choose))
                count += 1
            for line in lines:
                line.step()
            for line in [one for one in lines if one.is_done]:
                line.close()
                check_answers(line, statuses)
                lines.remove(line)
            if time.monotonic() - last > 2:
                last = time.monotonic()
                if service.process.poll() is not None:
                    fail(f"it ended with {service.process.returncode}: {service.log_text()[-3000:]}")
                if service.ask("GET", "/healthz", timeout=60)[0] != 200:
                    fail("it is not healthy")
                if before is None and share_done() > 0.3:
                    before = process_state(service.process.pid)
        for line in lines:
            line.close()
        if service.process.poll() is not None:
            fail(f"it ended with {service.process.returncode}: {service.log_text()[-3000:]}")
        before = before or process_state(service.process.pid)
        deadline = time.monotonic() + 30  # waits for open connections to end
        while (after := process_state(service.process.pid))[1] > 40 and time.monotonic() < deadline:
            time.sleep(0.1)
        print(f"{count} conversations in {time.monotonic() - begun:.0f} s, answers by status: "
              f"{dict(sorted(statuses.items()))}")
        print(f"resident {before[0] >> 10} -> {after[0] >> 10} KiB, files {before[1]} -> {after[1]}, threads "
              f"{before[2]} -> {after[2]}, budget in use {service.metric('multum_http_memory_bytes') / 1024:.0f} KiB")
        if after[0] > before[0] + (options.memory_growth_max << 20) or after[2] > before[2] or after[1] > 40:
            fail("more memory, files or threads are in use than before")
        if service.metric("multum_http_memory_bytes") > 1 << 20:
            fail("the memory budget was not released")
        if min(statuses[one] for one in (200, 400, 404)) == 0:
            fail("a kind of answer never occurred")
        assert service.stop() == 0, service.log_text()[-3000:]
        found = FOUND.search(service.log_text())
        if found:
            at = max(0, found.start() - 200)
            fail(service.log_text()[at:at + 6000])


if __name__ == "__main__":
    main()
