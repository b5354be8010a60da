# SPDX-License-Identifier: Apache-2.0
"""Exceptions of the package. Each one carries the parts of its message."""


class Error(Exception):
    """A failed call. str() gives the complete message.

    file      file or image that the message is about, or ""
    found     value that was found, or ""
    expected  value that was expected, or ""
    """

    def __init__(self, message: str, file: str = "", found: str = "", expected: str = ""):
        super().__init__(message)
        self.file, self.found, self.expected = file, found, expected


class SettingError(Error, ValueError):
    """An argument or the value of a setting is wrong."""


class InputError(Error):
    """A file or an array cannot be used."""


class MachineError(Error):
    """The device, the driver, the disk or the memory cannot do the work at present."""


class VerificationError(Error):
    """A check of a finished file failed, or no settings reach a target."""


class Cancelled(Error):
    """A progress function asked to stop."""


class ServiceError(Error):
    """The service refused a request, or a job did not succeed."""


# Maps the value of multum_status in multum.h to an exception.
_KINDS = {1: Cancelled, 2: SettingError, 3: InputError, 4: MachineError, 5: VerificationError, 6: MachineError}


def make_error(status: int, message: str, file: str, found: str, expected: str) -> Error:
    return _KINDS.get(status, Error)(message, file, found, expected)
