"""What comes down the line to a controller, word by word; what a command does, the controller does."""

from __future__ import annotations

from typing import Any

from stereo_lab.arm import protocol as wire

TX_BYTES, STATUS_BYTES = 128, 100  # what the controller can keep for sending; a status needs less than that


class Interpreter:
    """Reads lines and answers them.

    Attributes
    ----------
    controller : stereo_lab.arm.virtual.controller.Controller
    checksum : bool, whether every line needs one
    tx : bytearray, what is to be sent
    """

    def __init__(self, controller: Any) -> None:
        self.controller, self.checksum, self.tx = controller, False, bytearray()
        self._line, self._too_long, self._asked = bytearray(), False, False
        self._last = (None, "")  # the number of the last numbered command, and its reply

    def say(self, text: str) -> None:
        """Send a line."""
        self.tx += (wire.seal(text) if self.checksum else text).encode("ascii") + b"\r\n"

    def feed(self, data: bytes) -> None:
        """Bytes from the host."""
        for byte in data:
            if byte in b"!?" and not self._line and not self._too_long:
                self._real_time(byte)
            elif byte in b"\r\n":
                self._end_of_line()
            elif len(self._line) < wire.LINE_MAX:
                self._line.append(byte)
            else:
                self._too_long = True

    @property
    def has_room(self) -> bool:
        """Whether a status can be sent without waiting."""
        return len(self.tx) < TX_BYTES - STATUS_BYTES

    def answer_questions(self) -> None:
        """One status for all ``?`` that came meanwhile."""
        if self._asked and self.has_room:
            self._asked = False
            self.say(wire.encode_status(self.controller.status()))

    def report(self) -> None:
        """A status that nobody asked for (``RP``); where the line is full it is left out, and counted."""
        if self.has_room:
            self.say(wire.encode_status(self.controller.status()))
        else:
            self.controller.dropped += 1

    def _real_time(self, byte):
        if byte == ord("!"):
            self.controller.halt(latch=True, fault="e")
            self.say("!estop")
        else:
            self.controller.is_heard()
            self._asked = True
            self.answer_questions()

    def _end_of_line(self):
        line, too_long = self._line.decode("latin-1"), self._too_long
        self._line, self._too_long = bytearray(), False
        try:
            if too_long:
                raise wire.ProtocolError(wire.TOO_LONG)
            command = wire.decode_command(line, self.checksum)
        except wire.ProtocolError as error:
            self._answer(wire.Reply(error.code, "", error.number))
            return
        if command is None:
            return
        self.controller.is_heard()
        if command.number is not None and command.number == self._last[0]:
            self.say(self._last[1])
            return
        try:
            reply = wire.Reply(0, self._execute(command) or "", command.number)
        except wire.ProtocolError as error:
            reply = wire.Reply(error.code, "", command.number)
        self._last = (command.number, wire.encode_reply(reply))
        self._answer(reply)

    def _answer(self, reply):
        self.say(wire.encode_reply(reply))

    def _execute(self, command):
        takes = COMMANDS.get(command.name)
        if takes is None:
            raise wire.ProtocolError(wire.COMMAND)
        run, least, most = takes
        if not least <= len(command.arguments) <= most:
            raise wire.ProtocolError(wire.ARGUMENT)
        return run(self, *command.arguments)

    def _id(self):
        return wire.IDENTITY

    def _enable(self, word):
        self.controller.enable(_flag(word))

    def _stop(self):
        self.controller.halt(hold=True)

    def _move(self, joint, goal, percent="100"):
        goals = [None, None]
        goals[_joint(joint)] = wire.read_number(goal, -1e6, 1e6)
        self.controller.move_to(goals, wire.read_number(percent, 1, 100) / 100)

    def _move_both(self, first, second, percent="100"):
        goals = [wire.read_number(goal, -1e6, 1e6) for goal in (first, second)]
        self.controller.move_to(goals, wire.read_number(percent, 1, 100) / 100)

    def _push(self, joint, duty, milliseconds):
        j, duty = _joint(joint), wire.read_number(duty, -255, 255)
        self.controller.push(j, int(duty), wire.read_number(milliseconds, 1, 2000))

    def _zero(self, joint, angle="0"):
        self.controller.zero(_joint(joint), wire.read_number(angle, -360, 360))

    def _home(self, joint):
        self.controller.home(_joint(joint))

    def _set(self, joint, name, value):
        j = _joint(joint)
        if name not in wire.PARAMETERS:
            raise wire.ProtocolError(wire.ARGUMENT)
        self.controller.set(j, name, wire.read_number(value, *wire.PARAMETERS[name]))

    def _get(self, joint, name):
        joint = self.controller.joints[_joint(joint)]
        if name not in (*joint.parameters, wire.HELD):  # a servo's joint has fewer
            raise wire.ProtocolError(wire.ARGUMENT)
        value = joint.held_v if name == wire.HELD else joint.parameters[name]
        return f"{round(value, 3) + 0.0:.3f}"  # no -0.000

    def _mode(self, word):
        if word not in ("pid", "rule"):
            raise wire.ProtocolError(wire.ARGUMENT)
        self.controller.follow_rule(word == "rule")

    def _report(self, milliseconds):
        self.controller.report_every(_period(milliseconds, 20))

    def _watchdog(self, milliseconds):
        self.controller.watchdog_ms = _period(milliseconds, 100)

    def _checksums(self, word):
        self.checksum = _flag(word)


COMMANDS = {
    "ID": (Interpreter._id, 0, 0), "EN": (Interpreter._enable, 1, 1), "ST": (Interpreter._stop, 0, 0),
    "MV": (Interpreter._move, 2, 3), "MA": (Interpreter._move_both, 2, 3), "PW": (Interpreter._push, 3, 3),
    "ZE": (Interpreter._zero, 1, 2), "HM": (Interpreter._home, 1, 1), "SET": (Interpreter._set, 3, 3),
    "GET": (Interpreter._get, 2, 2), "MODE": (Interpreter._mode, 1, 1), "RP": (Interpreter._report, 1, 1),
    "WD": (Interpreter._watchdog, 1, 1), "CS": (Interpreter._checksums, 1, 1),
}  # fmt: skip


def _joint(word):
    if word not in ("1", "2"):
        raise wire.ProtocolError(wire.ARGUMENT)
    return int(word) - 1


def _flag(word):
    if word not in ("0", "1"):
        raise wire.ProtocolError(wire.ARGUMENT)
    return word == "1"


def _period(milliseconds, least):
    value = wire.read_number(milliseconds, 0, 60000)
    if 0 < value < least:
        raise wire.ProtocolError(wire.LIMIT)
    return int(value)
