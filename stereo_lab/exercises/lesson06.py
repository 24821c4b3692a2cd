"""Questions of lesson 06: motors, and how to stop them."""

from __future__ import annotations

from stereo_lab.exercises.answers import Command, Function, Number, Wrong
from stereo_lab.exercises.question import Question, lesson
from stereo_lab.motion import slow_down_volts
from stereo_lab.recording import Recording

CRUISE, COUNTS = 180.0, 4094.4


def questions(recording: Recording) -> tuple[Question, ...]:
    """Six questions, the same for every recording; see :mod:`stereo_lab.exercises`."""
    return lesson("06", _command(), _volts(), _runs_on(), _rule(), _edges(), _blind())


def _command():
    return dict(
        asks="Which line turns joint 2 to −30°?",
        answer=Command(
            "MV 2 -30",
            (
                Wrong("MV 1 -30", "that turns the shoulder. Joints are counted from 1; the elbow is 2."),
                Wrong("MV -30 2", "the joint comes first, then the angle: this asks for joint −30."),
                Wrong("MV 2 30", "that is 30 degrees counter-clockwise. Minus is clockwise."),
                Wrong("MA 2 -30", "MA moves both joints: the shoulder to 2 degrees and the elbow to −30."),
                Wrong("MV elbow -30", "joints have numbers here: the elbow is 2."),
                Wrong("MV 2", "to where? The angle is missing."),
                Wrong("MA 0 -30", "MA moves both joints: the shoulder would go to 0."),
                Wrong("MV 3 -30", "there are two joints: 1 is the shoulder, 2 the elbow."),
                Wrong(
                    "MV 2 330",
                    "the same direction, but the joint would have to turn there by 330 degrees. Clockwise is minus.",
                ),
                Wrong("MOVE 2 -30", "the controller knows short words: MV."),
                Wrong("GET 2 -30", "GET asks for something. MV moves."),
                Wrong("MV 02 -30", "a joint is told by one digit: 2."),
            ),
            "joint, then angle.",
            also=("mv 2 -30", "MV  2  -30.0", "MV 2 -30 100"),
        ),
        hints=(
            "MV moves one joint: MV joint degrees.",
            "The elbow is joint 2. Clockwise is minus.",
            'line = "MV 2 ____"',
        ),
        code='line = "MV 2 -30"',
        reason="MV takes the joint and then the angle; PROTOCOL.md lists every command.",
        reference="MV 2 -30",
    )


def _volts():
    tries = ((75.0, 0.4, 180.0), (69.0, 0.53, 90.0), (79.0, 0.36, 300.0))
    return dict(
        asks="Write the voltage that turns a motor at a given speed.",
        answer=Function(
            volts_for, tries, 0.005, "V",
            (
                Wrong(lambda k, v0, w: w / k, "the dead band is missing: below it the motor does not turn at all."),
                Wrong(lambda k, v0, w: w * k + v0, "k is degrees per second for each volt: divide the speed by it."),
                Wrong(lambda k, v0, w: w / k - v0, "friction costs voltage: the dead band comes on top."),
                Wrong(lambda k, v0, w: (w - v0) / k, "V0 is in volts already, and comes on top: only the speed is divided by k."),
                Wrong(lambda k, v0, w: k * (w - v0), "that is a speed, as if the speed were the voltage. Solve for V."),
                Wrong(lambda k, v0, w: v0 - w / k, "both cost voltage: plus."),
                Wrong(lambda k, v0, w: w / (k + v0), "V0 is in volts: add it after the speed is divided by k."),
                Wrong(lambda k, v0, w: v0 * w / k, "friction costs voltage on top: plus, not times."),
                Wrong(lambda k, v0, w: w // k + v0, "// throws the decimals away. Divide by a single /."),
                Wrong(lambda k, v0, w: (v0 + w) * k, "k is degrees per second for each volt: divide the speed by it, and add V0."),
                Wrong(lambda k, v0, w: (w + v0) / k, "V0 is in volts already; only the speed is divided by k."),
            ),
            "the dead band first, then a volt for every k degrees per second.",
        ),
        hints=(
            "Turn the line speed = k·(V − V0) round.",
            "speed / k is in volts. Add what friction takes.",
            "return v0 + speed / ____",
        ),
        code="def volts_for(k, v0, speed):\n    return v0 + speed / k",
        reason="speed = k·(V − V0), solved for V.",
        reference=volts_for,
    )  # fmt: skip


def _runs_on():
    tries = ((0.06, 180.0), (0.03, 90.0), (0.1, 180.0))
    return dict(
        asks="Without friction: how far does a motor run on, when its voltage is taken away?",
        answer=Function(
            runs_on, tries, 0.01, "degrees",
            (
                Wrong(lambda t, w: 1000 * t * w, "the time constant is in seconds here, not in milliseconds."),
                Wrong(lambda t, w: w / t, "a sluggish motor (large τ) runs on farther, not less far."),
                Wrong(lambda t, w: t, "a fast motor runs on farther: the speed belongs into it."),
                Wrong(lambda t, w: 0.5 * t * w, "it does not slow down evenly: fast at first, then ever slower. Twice that."),
                Wrong(lambda t, w: 0.37 * t * w, "0.37 is how much of the speed is left after τ, not how far it turned."),
                Wrong(lambda t, w: 0.63 * t * w, "0.63 is how much of the speed is lost after τ, not how far it turned."),
                Wrong(lambda t, w: 2 * t * w, "after 2·τ it has nearly stopped, but it was slow for most of that time."),
            ),
            "seconds times degrees per second give degrees.",
        ),
        hints=(
            "Compare two lines that differ in one number only. Twice the τ, and twice the speed: what becomes of the degrees?",
            "Degrees come out when seconds are multiplied by degrees per second.",
            "return tau * ____",
        ),
        code="def runs_on(tau, speed):\n    return tau * speed",
        reason="Twice the τ or twice the speed gives twice the way, and 0.05 s at 180 °/s give 9°.",
        reference=runs_on,
    )  # fmt: skip


def _rule():
    tries = tuple((left, 5.0, 2.1, 1.4) for left in (40.0, 5.5, 4.5, 0.3, 0.0, -2.0)) + ((8.0, 12.0, 2.4, 1.3),)
    return dict(
        asks="Write the paper's rule: full speed, slow within the zone, brake at the goal.",
        answer=Function(
            slow_down_volts, tries, 1e-6, "V",
            (
                Wrong(
                    lambda left, zone, fast, slow: 0.0 if left <= 0 else slow if left > zone else fast,
                    "yours is slow far away and fast near the goal.",
                ),
                Wrong(
                    lambda left, zone, fast, slow: fast if left > zone else slow,
                    "yours never brakes: at the goal and past it the voltage must be 0.",
                ),
                Wrong(
                    lambda left, zone, fast, slow: 0.0 if left <= zone else fast,
                    "yours brakes where it should slow down, and never gets to the goal.",
                ),
                Wrong(
                    lambda left, zone, fast, slow: 0.0 if left == 0 else fast if abs(left) > zone else slow,
                    "past the goal (left below zero) yours drives on. Brake there too.",
                ),
                Wrong(
                    lambda left, zone, fast, slow: slow_down_volts(left, 5.0, fast, slow),
                    "right for a zone of 5 degrees only. Use zone_deg.",
                ),
            ),
            "three cases, in this order.",
        ),
        hints=(
            "Three cases: past the goal, in the zone, before it.",
            "left_deg is what is still to go; it is below zero past the goal.",
            "if left_deg <= 0:\n        return 0\n    return fast_v if left_deg > ____ else slow_v",
        ),
        code=(
            "def rule(left_deg, zone_deg, fast_v, slow_v):\n"
            "    if left_deg <= 0:\n"
            "        return 0\n"
            "    return fast_v if left_deg > zone_deg else slow_v"
        ),
        reason="Past the goal brake; else slow within the zone, fast before it.",
        reference=slow_down_volts,
    )  # fmt: skip


def _edges():
    right = COUNTS * CRUISE / 360
    return dict(
        asks="The encoder has 4094.4 edges on a turn of the joint, the joint makes 180° a second. How many edges a second?",
        answer=Number(
            right, 1.0, "",
            (
                Wrong(COUNTS * CRUISE, "180 degrees are half a turn, not 180 turns."),
                Wrong(COUNTS, "4094.4 edges are a whole turn; in a second the joint makes half of one."),
                Wrong(COUNTS / CRUISE, "that is edges for each degree, but of a turn of 180 degrees."),
                Wrong(COUNTS * 2, "180 degrees are half a turn, not two. And the 4094.4 are all edges already: no times four."),
                Wrong(COUNTS * CRUISE / 60, "the 180 are degrees a second, and a turn has 360."),
                Wrong(CRUISE / COUNTS, "upside down: edges for each turn, times turns a second."),
                Wrong(0.5, "that is how many turns it makes in a second. How many edges are on them?"),
                Wrong(COUNTS / 4, "that is a quarter of a turn. 180 degrees are half of one."),
                Wrong(COUNTS / 360, "that is the edges of one degree; there are 180 of them in a second."),
            ),
            "about 2,047 a second: a host must look more often than that, and well more, for a joint is a little faster at times.",
        ),
        hints=(
            "How many turns does the joint make in a second?",
            "180° of 360° is half a turn.",
            "edges_per_s = 4094.4 * 180 / ____",
        ),
        code="edges_per_s = 4094.4 * 180 / 360",
        reason="Half a turn a second, 4094.4 edges a turn.",
        reference=right,
    )  # fmt: skip


def _blind():
    return dict(
        asks="How far does a joint turn after the computer's last word, if it cruises at 180 degrees a second?",
        answer=Number(
            1.072 * CRUISE, 0.078 * CRUISE, "degrees",  # up to what a motor without friction runs on
            (
                Wrong(1.0, "that is how long it goes on, in seconds. How far does it get in that time?"),
                Wrong(90.0, "it does not slow down in that second: the controller knows nothing yet."),
                Wrong(0.12 * CRUISE, "that is how far it runs on once the voltage is gone. Before that it goes on for a whole second."),
                Wrong(0.0, "so it would be if the controller knew at once. It waits for a second."),
                Wrong(23.9, "that was the slow move of the cell above, at 30 percent of the speed, and from rest."),
                Wrong(360.0, "one second, not two."),
                Wrong(270.0, "one second, not one and a half."),
                Wrong(18.0, "that is how far it runs on once the voltage is gone. Before that it goes on for a whole second."),
                Wrong(54.0, "at 180 degrees a second, not at 30 percent of that: the question is about a cruise."),
            ),
            "half a turn, and a little more while it brakes: keep out of its whole reach.",
            also=(180, 180 + 0.05 * 180, 1.1 * 180, 180 + 21.3),
        ),
        hints=(
            "What does the controller do during the second in which it hears nothing?",
            "It goes on as if nothing had happened: 180 degrees a second, for a second. Then it runs on a little.",
            "blind_deg = 180 * ____",
        ),
        code="blind_deg = 180 * 1",
        reason="A second at full speed before the watchdog has run down; what it runs on after that is a tenth of it.",
        reference=180.0,
    )  # fmt: skip


def volts_for(k: float, v0: float, speed: float) -> float:
    """The voltage for a speed, V."""
    return v0 + speed / k


def runs_on(tau: float, speed: float) -> float:
    """How far a motor without friction runs on, degrees."""
    return tau * speed
