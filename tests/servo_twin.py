"""Two bus servos without hardware: what stands on their side of the wire, by the manual and by what others measured."""

from serial.serialutil import SerialBase, SerialException

from stereo_lab.arm.feetech.packets import EVERYBODY, HEADER, checksum, number, word

STEP = 360 / 4096
EEPROM, READ_ONLY = range(5, 40), {0, 1, 2, 3, 4, *range(56, 71)}


class Twin:
    """One servo: its table, where its motor stands, and its output behind a degree of play."""

    def __init__(self, id, position=2048, load=0.0):
        self.table = bytearray(87)
        self.table[0:9] = bytes([3, 10, 0, 9, 3, id, 0, 0, 1])
        self.put(9, (0).to_bytes(2, "little") + (4095).to_bytes(2, "little"))
        self.table[13:16] = bytes([70, 80, 40])
        self.put(16, (1000).to_bytes(2, "little"))
        self.table[19], self.table[34], self.table[35], self.table[36] = 44, 20, 200, 80
        self.kept = bytearray(self.table)
        self.position, self.speed, self.load, self.held, self.output = (
            float(position),
            0.0,
            load,
            False,
            position * STEP,
        )
        self.overloaded_s = 0.0
        self.power_up()

    def put(self, address, data):
        self.table[address : address + len(data)] = data

    def get(self, address, count=1):
        return int.from_bytes(self.table[address : address + count], "little")

    def power_up(self):
        self.table[:] = self.kept
        self.table[40:50] = bytes(8) + self.table[16:18]
        self.table[55], self.table[65] = 1, 0

    def write(self, address, data):
        for k, byte in enumerate(data, start=address):
            if k in READ_ONLY or k >= len(self.table):
                continue
            self.table[k] = byte
            if k in EEPROM and not self.table[55]:
                self.kept[k] = byte
        if address <= 40 < address + len(data) and self.table[40] == 128:
            self.put(31, word(int(self.position) - 2048, 11))
            self.position, self.table[40] = 2048.0, 0
        if address <= 42 < address + len(data) or address < 42 < address + len(data):
            self.table[40] = 1  # a goal switches it on by itself

    def live(self, seconds):
        if self.table[40] != 1:
            self.speed = 0.0
            self.position += -self.load * 400 * seconds  # nothing holds it: what hangs on it pulls it down
        elif not self.held:
            low, high = self.get(9, 2), self.get(11, 2)
            goal = min(max(number(self.table[42:44]), low), high) if low != high else number(self.table[42:44])
            most = number(self.table[46:48]) or 3400
            left = goal - self.position
            self.speed = max(-most, min(most, left / max(seconds, 1e-9)))
            self.position += self.speed * seconds
        pushes = self.table[40] == 1 and self.held and abs(number(self.table[42:44]) - self.position) > 20
        self.overloaded_s = self.overloaded_s + seconds if pushes else 0.0
        if self.overloaded_s > self.table[35] / 100:
            self.table[65] |= 0x20
        if self.table[40] != 1:
            self.table[65] &= ~0x20
        half = 0.5
        ahead = self.position * STEP - self.output
        self.output += max(0.0, ahead - half) + min(0.0, ahead + half)
        moving = abs(self.speed) > 1
        self.put(
            56,
            word(round(self.position))
            + word(round(self.speed) if moving else 0)
            + word(900 if pushes else 40, 10)
            + bytes([74, 31, 0]),
        )
        self.table[66] = moving


class TwinPort(SerialBase):
    """A pyserial port with some twins on its wire; time is told by ``clock``."""

    def __init__(self, twins, clock, echo=False):
        super().__init__()
        self.twins, self.clock, self.echo = {t.table[5]: t for t in twins}, clock, echo
        self.last, self.heard, self.arrived = clock(), bytearray(), bytearray()
        self.silent, self.unplugged, self.noise, self.said = False, False, 0, []
        self.is_open, self._timeout = True, 0.002

    def open(self):
        self.is_open = True

    def close(self):
        self.is_open = False

    def _reconfigure_port(self):
        pass

    def _check(self):
        if self.unplugged:
            raise SerialException("the device is gone")

    def let_pass(self):
        now = self.clock()
        while self.last < now - 1e-9:
            step = min(0.005, now - self.last)
            for twin in self.twins.values():
                twin.live(step)
            self.last += step

    def write(self, data):
        self._check()
        self.let_pass()
        self.said.append(bytes(data))
        if self.echo:
            self.arrived += data
        self.heard += data
        self._frames()
        return len(data)

    def _frames(self):
        while (start := self.heard.find(HEADER)) >= 0 and len(self.heard) >= start + 4:
            del self.heard[:start]
            whole = self.heard[3] + 4
            if len(self.heard) < whole:
                return
            body, given = bytes(self.heard[2 : whole - 1]), self.heard[whole - 1]
            del self.heard[:whole]
            if checksum(body) == given and not self.silent:
                self._obey(body[0], body[2], body[3:])

    def _obey(self, id, instruction, rest):
        if instruction == 0x83:
            address, count = rest[:2]
            for k in range(2, len(rest), count + 1):
                if rest[k] in self.twins:
                    self.twins[rest[k]].write(address, rest[k + 1 : k + 1 + count])
            return
        for own, twin in list(self.twins.items()):
            if id not in (own, EVERYBODY):
                continue
            data = b""
            if instruction == 0x02:
                data = bytes(twin.table[rest[0] : min(rest[0] + rest[1], 87)])
            elif instruction == 0x03:
                twin.write(rest[0], rest[1:])
                self.twins = {t.table[5]: t for t in self.twins.values()}
            if id != EVERYBODY or instruction == 0x01:
                self._answer(own, twin.table[65], data)

    def _answer(self, id, error, data):
        body = bytes([id, len(data) + 2, error]) + data
        sent = bytearray(HEADER + body + bytes([checksum(body)]))
        if self.noise:
            sent[-2] ^= 1
            self.noise -= 1
        self.arrived += sent

    def read(self, size=1):
        self._check()
        self.let_pass()
        data = bytes(self.arrived[:size])
        del self.arrived[:size]
        return data

    @property
    def in_waiting(self):
        self._check()
        return len(self.arrived)

    def reset_input_buffer(self):
        if self.unplugged:
            raise Exception("Input/output error")  # as termios.error: neither an OSError nor a SerialException
        self.arrived.clear()

    def reset_output_buffer(self):
        pass

    def flush(self):
        pass
