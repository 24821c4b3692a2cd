"""Questions of lesson 06: motors, and how to stop them."""

from __future__ import annotations

import math

from stereo_lab.exercises.answers import Command, Function, Number, Wrong
from stereo_lab.exercises.question import Question, lesson
from stereo_lab.exercises.reading import A_RATE
from stereo_lab.exercises.seats import numbers
from stereo_lab.motion import slow_down_volts
from stereo_lab.recording import Recording

CRUISE, COUNTS = 180.0, 4094.4


def questions(recording: Recording) -> tuple[Question, ...]:
    """Six questions, the same for every recording but for a seat's own; see :mod:`stereo_lab.exercises`."""
    return lesson("06", _command(-numbers(recording.seat).elbow_deg), _volts(), _runs_on(), _rule(), _edges(), _blind())


def _command(turn):
    """The elbow is to be turned clockwise, to so many degrees below zero."""
    return dict(
        asks=f"Which line turns joint 2 to −{turn}°?",
        answer=Command(
            f"MV 2 -{turn}",
            (
                Wrong(f"MV 1 -{turn}", "that turns the shoulder. Joints are counted from 1; the elbow is 2."),
                Wrong(f"MV -{turn} 2", f"the joint comes first, then the angle: this asks for joint −{turn}."),
                Wrong(f"MV 2 {turn}", f"that is {turn} degrees counter-clockwise. Minus is clockwise."),
                Wrong(f"MA 2 -{turn}", f"MA moves both joints: the shoulder to 2 degrees and the elbow to −{turn}."),
                Wrong(f"MV elbow -{turn}", "joints have numbers here: the elbow is 2."),
                Wrong("MV 2", "to where? The angle is missing."),
                Wrong(f"MA 0 -{turn}", "MA moves both joints: the shoulder would go to 0."),
                Wrong(f"MV 3 -{turn}", "there are two joints: 1 is the shoulder, 2 the elbow."),
                Wrong(
                    f"MV 2 {360 - turn}",
                    f"the same direction, but the joint would have to turn there by {360 - turn} degrees. Clockwise is minus.",
                ),
                Wrong(f"MOVE 2 -{turn}", "the controller knows short words: MV."),
                Wrong(
                    f"MV 1 {turn}",
                    "that turns the shoulder, and counter-clockwise. The elbow is joint 2; clockwise is minus.",
                ),
                Wrong(f"MV 0 -{turn}", "joints are counted from 1: the shoulder is 1, the elbow 2."),
                Wrong(f"MV joint -{turn}", "in the place of the word joint stands its number: the elbow is 2."),
                Wrong(f"MV two -{turn}", "joints are told by a digit: 2."),
                Wrong(f"MV -{turn}", "which joint? Its number stands between the command and the angle."),
                Wrong(f"EN 2 -{turn}", "EN switches the motors on. MV moves."),
                Wrong(f"SET 2 -{turn}", "SET changes a parameter. MV moves."),
                Wrong(f"MV 2 -{turn / 10:g}", "ten times too small. Is a zero missing?"),
                Wrong(f"MV 2 {180 - turn}", "that is the triangle's own angle. θ2 is counted from the stretched arm."),
                Wrong(f"GO 2 -{turn}", "the controller does not know GO: it says something else. MV moves."),
                Wrong(f"TURN 2 -{turn}", "the controller knows short words: MV."),
                Wrong(f"GET 2 -{turn}", "GET asks for something. MV moves."),
                Wrong(f"MV 02 -{turn}", "a joint is told by one digit: 2."),
            ),
            "joint, then angle.",
            also=(f"mv 2 -{turn}", f"MV  2  -{turn}.0", f"MV 2 -{turn} 100"),
        ),
        hints=(
            "MV moves one joint: MV joint degrees.",
            "The elbow is joint 2. Clockwise is minus.",
            'line = "MV 2 ____"',
        ),
        code=f'line = "MV 2 -{turn}"',
        reason="MV takes the joint and then the angle; PROTOCOL.md lists every command.",
        reference=f"MV 2 -{turn}",
    )


def _volts():
    tries = ((75.0, 0.4, 180.0), (69.0, 0.53, 90.0), (79.0, 0.36, 300.0))
    return dict(
        asks="Write the voltage that turns a motor at a given speed.",
        answer=Function(
            volts_for, tries, 0.005, "V",
            (
                Wrong(lambda k, v0, w: (w - k) / v0, "k is degrees per second for each volt: divide by it. V0 is in volts: it comes on top."),
                Wrong(lambda k, v0, w: w / k, "the dead band is missing: below it the motor does not turn at all."),
                Wrong(lambda k, v0, w: w * k + v0, "k is degrees per second for each volt: divide the speed by it."),
                Wrong(lambda k, v0, w: w / k - v0, "friction costs voltage: the dead band comes on top."),
                Wrong(lambda k, v0, w: (w - v0) / k, "V0 is in volts already, and comes on top: only the speed is divided by k."),
                Wrong(lambda k, v0, w: k * (w - v0), "that is a speed, as if the speed were the voltage. Solve for V."),
                Wrong(lambda k, v0, w: k / (w - v0), "upside down, and the dead band is taken from a speed. First speed / k, in volts; then add V0."),
                Wrong(lambda k, v0, w: k * v0 / w, "that leaves no volts: k·V0 is a speed. Solve speed = k·(V − V0) for V, one step at a time."),
                Wrong(lambda k, v0, w: w / (k - v0), "V0 is in volts: add it after the speed is divided by k."),
                Wrong(lambda k, v0, w: k / w + v0, "upside down: the speed belongs above the line, k below it."),
                Wrong(lambda k, v0, w: v0 - w / k, "both cost voltage: plus."),
                Wrong(lambda k, v0, w: w - v0 / k, "only the speed is divided by k. What friction takes comes on top: plus V0."),
                Wrong(lambda k, v0, w: w / k / v0, "V0 comes on top: plus, and nothing is divided by it."),
                Wrong(lambda k, v0, w: math.degrees(w) / k + v0, "the speed is in degrees per second already."),
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
    # A flywheel at last, as sluggish as no motor: what a loop that ends early leaves out can be seen there
    tries = ((0.06, 180.0), (0.03, 90.0), (0.1, 180.0), (30.0, 90.0))
    return dict(
        asks="Without friction: how far does a motor run on, when its voltage is taken away?",
        answer=Function(
            runs_on, tries, 0.01, "degrees",
            (
                Wrong(lambda t, w: t * (w - 0.001), "the loop ends at 0.001 degrees per second, a little early. What formula gives its four numbers?"),
                Wrong(lambda t, w: 1000 * t * w, "the time constant is in seconds here, not in milliseconds."),
                Wrong(lambda t, w: w / t, "a sluggish motor (large τ) runs on farther, not less far."),
                Wrong(lambda t, w: t, "a fast motor runs on farther: the speed belongs into it."),
                Wrong(lambda t, w: 0.5 * t * w, "it does not slow down evenly: fast at first, then ever slower. Twice that."),
                Wrong(lambda t, w: 0.37 * t * w, "0.37 is how much of the speed is left after τ, not how far it turned."),
                Wrong(lambda t, w: (1 - math.exp(-1)) * t * w, "that is how much of the speed is lost after τ, not how far it turned."),
                Wrong(lambda t, w: 0.63 * t * w, "0.63 is how much of the speed is lost after τ, not how far it turned."),
                Wrong(lambda t, w: 3 * t * w, "after 3·τ it has nearly stopped, but it was slow for most of that time."),
                Wrong(lambda t, w: t + w, "seconds and degrees per second are not added. What gives degrees?"),
                Wrong(lambda t, w: w - t, "seconds and degrees per second are not subtracted. What gives degrees?"),
                Wrong(lambda t, w: t * w * 360, "the speed is in degrees a second already, not in turns."),
                Wrong(lambda t, w: 1.5 * t * w, "that leaves room to spare, as a rule for braking should. How far does it turn by itself?"),
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
    tries = tuple((left, 5.0, 2.1, 1.4) for left in (40.0, 9.0, 5.5, 4.5, 0.3, 0.01, 0.0, -0.01, -2.0, -8.0)) + (
        (8.0, 12.0, 2.4, 1.3),
    )
    return dict(
        asks="Write the paper's rule: full speed, slow within the zone, brake at the goal.",
        answer=Function(
            slow_down_volts, tries, 1e-6, "V",
            (
                Wrong(
                    lambda left, zone, fast, slow: slow if left > zone else fast,
                    "yours is slow far away and fast near the goal, and never brakes.",
                ),
                Wrong(
                    lambda left, zone, fast, slow: fast * (left > zone) + slow * (left > 0),
                    "before the zone yours adds both voltages: there left_deg is above 0 as well.",
                ),
                Wrong(
                    lambda left, zone, fast, slow: fast if abs(left) > zone else slow if left > 0 else 0.0,
                    "far past the goal yours goes on at full speed: abs takes the sign away that says which side it is on.",
                ),
                Wrong(
                    lambda left, zone, fast, slow: fast if left > zone else slow if left >= 0 else 0.0,
                    "just at the goal yours drives on: brake at 0 as well, <= and not <.",
                ),
                Wrong(
                    lambda left, zone, fast, slow: fast if left > zone else slow if left > -1 else 0.0,
                    "at the goal and a little past it yours still drives on: brake as soon as left_deg is 0.",
                ),
                Wrong(
                    lambda left, zone, fast, slow: slow if 0 < left <= zone else fast,
                    "past the goal yours drives on, at full speed: 0 volts there.",
                ),
                Wrong(
                    lambda left, zone, fast, slow: fast if left > zone else slow if left != 0 else 0.0,
                    "it brakes at exactly 0 only, and past the goal yours drives on: <= 0, not == 0.",
                ),
                Wrong(
                    lambda left, zone, fast, slow: fast if left > zone else slow if left > 0 else -fast,
                    "past the goal yours drives back. The rule brakes there: 0 volts.",
                ),
                Wrong(
                    lambda left, zone, fast, slow: fast if left > zone else slow if left > 0 else -slow,
                    "past the goal yours drives back. The rule brakes there: 0 volts.",
                ),
                Wrong(
                    lambda left, zone, fast, slow: fast if left > 0 else 0.0,
                    "the slow part is missing: slow_v and zone_deg change nothing in your result. Within the zone the voltage is slow_v.",
                ),
                Wrong(
                    lambda left, zone, fast, slow: fast if left < 0 else slow if left < zone else 0.0,
                    "left_deg is what is still to go: large far away, below zero past the goal. Yours takes it the other way round.",
                ),
                Wrong(
                    lambda left, zone, fast, slow: fast if left > zone else 0.0 if left > 0 else slow,
                    "yours brakes within the zone and drives on at the goal: the other way round.",
                ),
                Wrong(
                    lambda left, zone, fast, slow: fast if left > zone else slow if left < 0 else 0.0,
                    "yours brakes within the zone and drives on past the goal, where left_deg is below zero: the other way round.",
                ),
                Wrong(
                    lambda left, zone, fast, slow: 0.0 if left > zone else slow if left > 0 else fast,
                    "yours brakes far away and is fast past the goal: the other way round.",
                ),
                Wrong(
                    lambda left, zone, fast, slow: slow + (fast - slow) * left / zone,
                    "that slows down little by little. The paper's rule has two voltages: fast before the zone, slow within it.",
                ),
                Wrong(
                    lambda left, zone, fast, slow: (fast + slow) / 2 if left < zone else fast,
                    "within the zone it is slow_v itself, no mean of the two; and at the goal and past it 0.",
                ),
                Wrong(
                    lambda left, zone, fast, slow: slow * left / zone if left < zone else fast,
                    "that slows down little by little. The paper's rule has two voltages: fast before the zone, slow within it.",
                ),
                Wrong(
                    lambda left, zone, fast, slow: fast * left / zone,
                    "that slows down little by little. The paper's rule has two voltages: fast before the zone, slow within it.",
                ),
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
            borders=(((5.0, 5.0, 2.1, 1.4), (2.1, 1.4)),),
            of_all=lambda volts: _brakes_early(tries, volts),
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
            right, 1.0, A_RATE,
            (
                Wrong(COUNTS * CRUISE, "180 degrees are half a turn, not 180 turns."),
                Wrong(COUNTS, "4094.4 edges are a whole turn; in a second the joint makes half of one."),
                Wrong(COUNTS / CRUISE, "that is edges for each degree, but of a turn of 180 degrees."),
                Wrong(COUNTS * 2, "180 degrees are half a turn, not two. And the 4094.4 are all edges already: no times four."),
                Wrong(COUNTS * CRUISE / 60, "the 180 are degrees a second, and a turn has 360."),
                Wrong(CRUISE / COUNTS, "upside down: edges for each turn, times turns a second."),
                Wrong(2.0, "in two seconds it makes one turn. How many turns in one second, and how many edges on them?"),
                Wrong(COUNTS * 360, "360 degrees belong below the line: they are one turn."),
                Wrong(COUNTS * 4, "the 4094.4 are all edges already: no times four. And 180 degrees are half a turn."),
                Wrong(COUNTS / 8, "the 4094.4 are all edges already: no divided by four."),
                Wrong(COUNTS / 60, "the 180 are degrees a second, not turns a minute. How many turns a second are they?"),
                Wrong(COUNTS / CRUISE / 360, "times 180 degrees, over the 360 of a turn: the more degrees a second, the more edges."),
                Wrong(360 / COUNTS, "upside down: that is degrees for each edge. How many edges has half a turn?"),
                Wrong(CRUISE * 360, "the edges are missing: 4094.4 on a turn, and how many turns in a second?"),
                Wrong(CRUISE, "that is how many degrees it turns in a second. How many edges are on them?"),
                Wrong(COUNTS / 3, "180 degrees are half a turn, not a third."),
                Wrong(5000.0, "that is how often a computer looks, further down. How many edges come?"),
                Wrong(0.5, "that is how many turns it makes in a second. How many edges are on them?"),
                Wrong(COUNTS / 4, "that is a quarter of a turn. 180 degrees are half of one."),
                Wrong(COUNTS / 360, "that is the edges of one degree; there are 180 of them in a second."),
            ),
            "about 2,047 a second: a host must look more often than that, and well more, for a joint is a little faster at times.",
            known={"4094.4": COUNTS, "180": CRUISE, "360": 360, "pi": math.pi},
            ask="What part of a turn does the joint make in a second, and how many edges are on it?",
            small="so many edges are on less than half a turn. What part of a turn does the joint make in a second?",
            large="so many edges are on more than half a turn. What part of a turn does the joint make in a second?",
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
                Wrong(math.pi, "that is half a turn in radians. The joint counts in degrees, and its cruise is in degrees a second."),
                Wrong(90.0, "it does not slow down in that second: the controller knows nothing yet."),
                Wrong(0.12 * CRUISE, "that is how far it runs on once the voltage is gone. Before that it goes on for a whole second."),
                Wrong(0.0, "so it would be if the controller knew at once. It waits for a second."),
                Wrong(23.9, "that was the slow move of the cell above, at 30 percent of the speed, and from rest."),
                Wrong(360.0, "one second, not two."),
                Wrong(270.0, "one second, not one and a half."),
                Wrong(18.0, "that is how far it runs on once the voltage is gone. Before that it goes on for a whole second."),
                Wrong(0.2 * CRUISE, "so it would be if it heard of it after a fifth of a second. The watchdog waits a whole second."),
                Wrong(1.2 * CRUISE, "that is for 1.2 s at full speed. The watchdog waits one second; then it brakes, and that is quick."),
                Wrong(1.4 * CRUISE, "that is for the whole 1.4 s of the table above. The watchdog waits one second; then it brakes, and that is quick."),
                Wrong(1.6, "that is what the slow move ran on after its second. Before that it turned, for a whole second, at full speed here."),
                Wrong(22.3, "that was the slow move after one second, from rest and at 30 percent. Here it cruises at full speed."),
                Wrong(22.3 / 0.3, "the slow move began from rest and had to speed up first. Here it is at full speed from the start."),
                Wrong(23.9 / 0.3, "the slow move began from rest and had to speed up first. Here it is at full speed from the start."),
                Wrong(160.0, "that is where the slow move was told to go. How far does a cruise take it in a second?"),
                Wrong(30.0, "that is the speed of the slow move, in percent. How far does a cruise take it in a second?"),
                Wrong(9.0, "that is how far it runs on once the voltage is gone. Before that it goes on for a whole second."),
                Wrong(14.7, "that is how far it runs on once the voltage is gone. Before that it goes on for a whole second."),
                Wrong(10.7, "that is how far it runs on once the voltage is gone. Before that it goes on for a whole second."),
                Wrong(5.0, "a few degrees are what a wrong wire costs. Silence costs a whole second at full speed."),
                Wrong(54.0, "at 180 degrees a second, not at 30 percent of that: the question is about a cruise."),
            ),
            "half a turn, and a little more while it brakes: keep out of its whole reach.",
            small="so far it gets before the watchdog has run down. How long does that take, and how far does it turn meanwhile?",
            beside=(
                (".*(at once|immediately|right away|not at all|instantly).*", "so it would be if the controller knew at once. It waits for a second: how far does the joint turn in it?"),
                (".*(goal|end|switch|stop|160).*", "how far a cruise takes it in the second that the watchdog waits, in degrees?"),
            ),
            large="so far it would get in more than the second that the watchdog waits. How far does it turn in one?",
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


def _brakes_early(tries, volts):
    """What to say where all is right, but that the motor brakes at places within the zone; else ""."""
    if not all(isinstance(given, (int, float)) for given in volts):
        return ""
    off = [(t[0], t[1], v) for t, v in zip(tries, volts, strict=False) if not math.isclose(v, slow_down_volts(*t))]
    if not off or any(given or not 0 < left <= zone for left, zone, given in off):
        return ""
    still = max(left for left, *_ in off)
    return (
        f"yours brakes too early, with {still:g}° still to go: as long as left_deg is above 0 there is something to go."
    )


def volts_for(k: float, v0: float, speed: float) -> float:
    """The voltage for a speed, V."""
    return v0 + speed / k


def runs_on(tau: float, speed: float) -> float:
    """How far a motor without friction runs on, degrees."""
    return tau * speed
