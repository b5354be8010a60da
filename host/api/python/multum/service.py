# SPDX-License-Identifier: Apache-2.0
"""A client of `multum serve` over HTTP (docs/reference/service.md). Uses only the standard library and needs no
libmultum.

    service = Service("http://127.0.0.1:8470")
    job = service.submit("bake", input="/srv/maps/rock_normal.png", output="/srv/maps/rock.ndf.exr", lobes=4)
    for event in job.events():
        print(event["event"], event)
    job.wait()
"""
from __future__ import annotations

import http.client
import json
import os
import shutil
import tempfile
import time
import urllib.error
import urllib.parse
import urllib.request
from typing import Any, Dict, Iterable, Iterator, List, Optional, Tuple

from ._errors import Error, ServiceError

_ENDED = ("succeeded", "dead", "cancelled")
_SUBMISSION = ("output", "queue", "label", "priority", "needs", "attempt_max", "deadline_s", "memory_bytes", "again")


class Service:
    """A service at a URL.

    url    default: $MULTUM_SERVER, or else http://127.0.0.1:8470
    token  text of the token; default: the first line of the file $MULTUM_TOKEN_FILE, if that is set
    """

    def __init__(self, url: Optional[str] = None, token: Optional[str] = None, timeout_s: float = 60.0):
        self.url = (url or os.environ.get("MULTUM_SERVER") or "http://127.0.0.1:8470").rstrip("/")
        if token is None and os.environ.get("MULTUM_TOKEN_FILE"):
            with open(os.environ["MULTUM_TOKEN_FILE"], encoding="utf-8") as file:
                token = file.readline().strip()
        self._token = token
        self._timeout_s = timeout_s

    def _open(self, method: str, path: str, body: Any = None, headers: Optional[Dict[str, str]] = None,
              timeout_s: Optional[float] = None) -> Any:
        request = urllib.request.Request(self.url + path, data=body, method=method, headers=headers or {})
        if self._token:
            request.add_header("Authorization", "Bearer " + self._token)
        try:
            return urllib.request.urlopen(request, timeout=timeout_s or self._timeout_s)
        except urllib.error.HTTPError as error:
            text = error.read().decode("utf-8", "replace")
            try:
                text = json.loads(text)["error"]["message"]
            except (ValueError, KeyError, TypeError):
                pass
            raise ServiceError(f"{self.url}{path}: the service answered {error.code}: {text}", self.url,
                               str(error.code)) from None
        except OSError as error:
            reason = getattr(error, "reason", error)
            raise ServiceError(f"{self.url}: cannot be reached: {reason}, expected a running `multum serve`", self.url,
                               str(reason), "a running `multum serve`") from None

    def _json(self, method: str, path: str, value: Any = None) -> Any:
        body = None if value is None else json.dumps(value).encode()
        with self._open(method, path, body, {"Content-Type": "application/json"} if body else None) as answer:
            return json.loads(answer.read() or b"null")

    def submit(self, type: str, output: str = "", **given: Any) -> "Job":
        """Submits a job: "bake", "export", "scene", "infer" or "pack".

        output  absolute path below a root of the service; without a leading slash the service keeps the result itself
        given   parameters of the job, such as input and lobes; and queue, label, priority, needs (numbers or jobs),
                attempt_max, deadline_s, memory_bytes, again

        If the service has a job with the same work and output, it returns that job, unless again=True.
        """
        submission: Dict[str, Any] = {"type": type, "output": output}
        submission.update((name, given.pop(name)) for name in _SUBMISSION if name in given)
        if "needs" in submission:
            submission["needs"] = [int(getattr(job, "id", job)) for job in submission["needs"]]
        submission["parameters"] = given
        return Job(self, self._json("POST", "/v1/jobs", submission))

    def job(self, id: int) -> "Job":
        """Returns the job with this number."""
        return Job(self, self._json("GET", f"/v1/jobs/{int(id)}"))

    def jobs(self, state: Optional[str] = None, queue: Optional[str] = None, limit: int = 100) -> "List[Job]":
        """Lists jobs, the newest first."""
        asked = {"state": state, "queue": queue, "limit": limit}
        query = urllib.parse.urlencode({name: value for name, value in asked.items() if value is not None})
        return [Job(self, one) for one in self._json("GET", "/v1/jobs?" + query)["jobs"]]

    def upload(self, path: "os.PathLike[str] | str", name: Optional[str] = None) -> str:
        """Stores a file as an input of later jobs, and returns the path to give as `input`."""
        name = name or os.path.basename(os.fspath(path))
        with open(path, "rb") as file:
            size = os.fstat(file.fileno()).st_size
            headers = {"Content-Length": str(size), "Content-Type": "application/octet-stream"}
            with self._open("PUT", "/v1/uploads/" + urllib.parse.quote(name, safe=""), file, headers) as answer:
                return json.loads(answer.read())["path"]

    def wait(self, jobs: "Iterable[Job]", timeout_s: Optional[float] = None) -> "List[Job]":
        """Waits until all jobs have ended, and returns them. Raises ServiceError for the first that did not succeed."""
        limit = None if timeout_s is None else time.monotonic() + timeout_s
        return [job.wait(None if limit is None else max(0.0, limit - time.monotonic())) for job in list(jobs)]


def _file_mode() -> int:
    """Returns the mode of new files. os.umask() would change the mask of the whole process for a moment."""
    with open("/proc/self/status", encoding="ascii", errors="replace") as status:
        for line in status:
            if line.startswith("Umask:"):
                return 0o666 & ~int(line.split()[1], 8)
    return 0o644


class Job:
    """A job of a service. `state` and the other fields are those of the last answer; refresh() asks again."""

    def __init__(self, service: Service, fields: Dict[str, Any]):
        self._service = service
        self.fields = fields

    id = property(lambda self: self.fields["id"], doc="number of the job")
    state = property(lambda self: self.fields["state"], doc="waiting, queued, running, publishing, succeeded, ...")
    message = property(lambda self: self.fields["message"], doc="reason for the state")
    output = property(lambda self: self.fields["output"], doc="absolute path of the result; empty: none")
    has_ended = property(lambda self: self.state in _ENDED, doc="True if the job is succeeded, dead or cancelled")

    def __repr__(self) -> str:
        return f"<Job {self.id} {self.fields['type']} {self.state}>"

    def _path(self, part: str = "") -> str:
        return f"/v1/jobs/{self.id}{part}"

    def refresh(self) -> "Job":
        """Asks the service for the job's present state."""
        self.fields = self._service._json("GET", self._path())
        return self

    def events(self, timeout_s: Optional[float] = None) -> "Iterator[Dict[str, Any]]":
        """Yields the job's changes as dictionaries until the job has ended. Reconnects if the service restarts."""
        limit = None if timeout_s is None else time.monotonic() + timeout_s
        failures, last = 0, None
        while True:
            try:
                if self.refresh().has_ended:
                    return
                headers = {} if last is None else {"Last-Event-ID": last}
                with self._service._open("GET", self._path("/events"), headers=headers, timeout_s=30.0) as stream:
                    failures = 0
                    for last, event in _parse_events(stream, last):
                        if event is not None:
                            yield event
                        # The service keeps the stream open after the job's end, and sends pulses.
                        if (event or self.refresh().fields).get("state") in _ENDED:
                            break
                        if limit is not None and time.monotonic() > limit:
                            break
            except (OSError, http.client.HTTPException, ServiceError) as error:
                failures += 1
                is_refused = isinstance(error, ServiceError) and error.found.startswith("4")  # 404: the job is purged
                if is_refused or failures > 60:
                    raise
                time.sleep(1.0)
            if limit is not None and time.monotonic() > limit and not self.has_ended:
                raise ServiceError(f"job {self.id} is {self.state} after {timeout_s} s, expected it to end", "",
                                   self.state, "a job that has ended")

    def wait(self, timeout_s: Optional[float] = None) -> "Job":
        """Waits until the job has ended. Raises ServiceError if it did not succeed, or after `timeout_s`."""
        for _ in self.events(timeout_s):
            pass
        if self.state != "succeeded":
            raise ServiceError(f"job {self.id} is {self.state}: {self.message}", "", self.state, "succeeded")
        return self

    def cancel(self) -> None:
        """Cancels the job. Raises ServiceError if it has ended."""
        self._service._json("POST", self._path("/cancel"), {})

    def retry(self) -> None:
        """Queues a dead or cancelled job again."""
        self._service._json("POST", self._path("/retry"))

    def log(self) -> str:
        """Returns the log of the last attempt."""
        with self._service._open("GET", self._path("/log")) as answer:
            return answer.read().decode("utf-8", "replace")

    def fetch(self, path: "os.PathLike[str] | str") -> str:
        """Downloads the result to a file, which appears complete or not at all; a folder arrives as a .tar file."""
        path = os.fspath(path)
        folder = os.path.dirname(os.path.abspath(path))
        with self._service._open("GET", self._path("/result")) as answer:
            handle, temporary = tempfile.mkstemp(prefix=".multum-fetch-", dir=folder)
            try:
                with os.fdopen(handle, "wb") as file:
                    shutil.copyfileobj(answer, file)
                expected = answer.headers.get("Content-Length")
                if expected is not None and os.path.getsize(temporary) != int(expected):
                    raise Error(f"{path}: the download ended early, found {os.path.getsize(temporary)} bytes, expected "
                                f"{expected}", path, str(os.path.getsize(temporary)), expected)
                os.chmod(temporary, _file_mode())
                os.replace(temporary, path)
            except BaseException:
                if os.path.exists(temporary):
                    os.remove(temporary)
                raise
        return path


def _parse_events(stream: Any, last: Optional[str]) -> "Iterator[Tuple[Optional[str], Optional[Dict[str, Any]]]]":
    """Yields (number of the last event, event). The event is None for a pulse, which shows that the service lives."""
    data: List[str] = []
    kind = ""
    for raw in stream:
        line = raw.decode("utf-8", "replace").rstrip("\r\n")
        if line.startswith("data:"):
            data.append(line[5:].strip())
        elif line.startswith("event:"):
            kind = line[6:].strip()
        elif line.startswith("id:"):
            last = line[3:].strip()
        elif line == ": pulse":
            yield last, None
        elif not line and data:
            event = json.loads("\n".join(data))
            if isinstance(event, dict):
                event.setdefault("event", kind)
                yield last, event
            data, kind = [], ""
