# SPDX-License-Identifier: Apache-2.0
"""Checks command lines in pages against the --help of the programs, and against the text of the scripts in tools/."""
import functools
import pathlib
import re
import shlex
import subprocess

PROGRAMS = ("multum", "multum-view", "multum-decode", "multum-bench", "multum-drill", "multum-farm-simulation")
# Each of these words runs the command that follows it.
BEFORE = {"sudo", "time", "env", "nohup", "exec", "do", "then", "else", "if", "while", "until", "!", "{", "python3",
          "bash", "node"}
END = re.compile(r"[;|&()]+|\}")
# The words after this command form a command line of multum.
RUNS_MULTUM = ("multum", "openjd")
HELP_TIMEOUT_S = 60
OPTION_LINE = re.compile(r" {1,8}(-[^\s]+)")
HEREDOC = re.compile(r"(?<!<)<<(?!<)-?\s*['\"]?(\w+)['\"]?")


def words_of(line):
    """Splits a shell line into words. Operators such as `;` are words. Raises ValueError for an open quotation."""
    lexer = shlex.shlex(line, posix=True, punctuation_chars=True)
    lexer.whitespace_split = True
    return list(lexer)


def shell_lines(lines):
    """Yields (offset, words) of each command line in a block. Joins lines at backslashes and within quotations, and
    skips here documents. The words are None if a quotation does not end."""
    offset = 0
    while offset < len(lines):
        begin, line = offset, lines[offset]
        offset += 1
        while True:
            if line.endswith("\\") and offset < len(lines):
                line = line[:-1] + lines[offset]
                offset += 1
                continue
            try:
                words = words_of(line)
                break
            except ValueError:
                if offset == len(lines):
                    words = None
                    break
                line += "\n" + lines[offset]
                offset += 1
        document = HEREDOC.search(line)
        if document:
            while offset < len(lines) and lines[offset].strip() != document[1]:
                offset += 1
            offset += 1
        if words is None or words:
            yield begin, words


def simple_commands(words):
    """Yields the commands of a line as lists of words, without redirections and variables."""
    command, is_target = [], False
    for word in [*words, ";"]:
        if END.fullmatch(word):
            while command and (command[0] in BEFORE or re.match(r"\w+=", command[0])):
                command.pop(0)
            if command:
                yield command
            command, is_target = [], False
        elif re.fullmatch(r"[<>&]+", word):
            is_target = True
        elif is_target:
            is_target = False
        else:
            command.append(word)


def listed_options(help_text):
    """Returns the options that --help lists at the beginning of lines."""
    found = set()
    for line in help_text.splitlines():
        match = OPTION_LINE.match(line)
        if match:
            found.update(name for name in match[1].split(",") if re.fullmatch(r"-\w|--[a-z][\w-]*", name))
    return found


class Programs:
    """Runs the programs of a folder with --help, and keeps their answers."""

    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        self.not_built = set()

    @functools.lru_cache(maxsize=None)
    def help_text(self, path):
        """Returns the help of a command, such as ("multum", "bake"), or None for an unknown command."""
        done = subprocess.run([self.folder / path[0], *path[1:], "--help"], capture_output=True, text=True,
                              check=False, timeout=HELP_TIMEOUT_S, stdin=subprocess.DEVNULL)
        usage = re.search(r"^Usage: \S*?([\w-]+(?: [\w-]+)*)(?= \[| [^\w-]|$)", done.stdout, re.MULTILINE)
        if len(path) > 1 and (usage is None or not (usage[1] + " ").startswith(" ".join(path) + " ")):
            return None
        return done.stdout if done.returncode == 0 else None

    def has(self, program):
        if (self.folder / program).is_file():
            return True
        self.not_built.add(program)
        return False

    def takes_commands(self, path):
        return bool(re.search(r"^Usage: .*SUBCOMMAND", self.help_text(path) or "", re.MULTILINE))

    def needs_command(self, path):
        return bool(re.search(r"^Usage: \S+(?: [\w-]+)* \[OPTIONS\] SUBCOMMAND", self.help_text(path) or "",
                              re.MULTILINE))


def is_placeholder(word):
    return re.fullmatch(r"[A-Z][A-Z_]*|.*(\.\.\.|…|<.*>|\[.*\]).*", word) is not None


def option_name(word):
    """Returns --lobes for --lobes=4, -o for -ofile, and "" for a word that is not an option, such as -1,2,3."""
    found = re.match(r"--[A-Za-z][\w-]*|-[A-Za-z]", word)
    return found[0] if found else ""


def program_faults(programs, words):
    """Yields the reasons why a command line of a program cannot work."""
    path = (words[0],)
    if not programs.has(path[0]) or programs.help_text(path) is None:
        return
    has_argument = False
    for at, word in enumerate(words[1:], start=1):
        if word == "--":
            break
        if word.startswith("-"):
            option = "" if is_placeholder(word) else option_name(word)
            if option and option not in listed_options(programs.help_text(path)):
                yield f"'{' '.join(path)}' has no option {option}"
            continue
        if has_argument or not programs.takes_commands(path):
            if path == RUNS_MULTUM and programs.help_text(("multum", word)) is not None:
                yield from program_faults(programs, ["multum", *words[at:]])
                break
            continue
        longer = (*path, word)
        if re.fullmatch(r"[a-z][\w-]*", word) and programs.help_text(longer) is not None:
            path = longer
        elif words[at - 1].startswith("-") and "=" not in words[at - 1]:
            continue  # the value of an option
        elif programs.needs_command(path) and not is_placeholder(word):
            yield f"'{' '.join(path)}' has no command '{word}'"
            return
        else:
            has_argument = not programs.needs_command(path)


@functools.lru_cache(maxsize=None)
def script_text(path):
    """Returns the text of a script. The text of a Python script includes the modules of its folder."""
    text = path.read_text(errors="replace")
    if "python" in text.partition("\n")[0]:
        text += "".join(module.read_text(errors="replace") for module in sorted(path.parent.glob("*.py")))
    return text


def script_faults(root, words):
    """Yields the reasons why a command line of a script in tools/ cannot work."""
    name = words[0].removeprefix("./")
    path = pathlib.Path(root) / name
    if not path.is_file():
        yield f"the script {name} does not exist"
        return
    for word in words[1:]:
        if word == "--":
            break
        option = option_name(word) if word.startswith("-") else ""
        if option and not re.search(rf"(?<![\w-]){option}(?![\w-])", script_text(path)):
            yield f"{name} has no option {option}"


def command_faults(root, programs, words):
    for command in simple_commands(words):
        program = command[0].rpartition("/")[2]
        if program in PROGRAMS:
            yield from program_faults(programs, [program, *command[1:]])
        elif re.match(r"(\./)?tools/[\w./-]+$", command[0]):
            yield from script_faults(root, command)


def is_command(text):
    """Returns whether a code span or an indented line is a command line of a program or a script."""
    word, space, rest = text.partition(" ")
    if not space or rest.startswith(("=", "(", ":")):
        return False
    return word.rpartition("/")[2] in PROGRAMS or re.match(r"(\./)?tools/[\w./-]+$", word) is not None
