"""Questions of lesson 05: inverse kinematics of a two-link arm."""

from __future__ import annotations

import math

from stereo_lab.exercises.answers import Function, Number, Wrong
from stereo_lab.exercises.question import Question, lesson
from stereo_lab.recording import Recording

DEGREE = math.pi / 180


def questions(recording: Recording) -> tuple[Question, ...]:
    """Six questions; see :mod:`stereo_lab.exercises`."""
    arm = recording.arm
    l1, l2 = float(arm.l1_mm), float(arm.l2_mm)
    poses = ((l1, l2, 0.0, 90.0), (l1, l2, 30.0, 45.0), (12.0, 9.0, -40.0, 100.0), (10.0, 6.0, -130.0, -40.0))
    points = (
        (l1, l2, 0.6 * (l1 + l2), 0.2 * (l1 + l2)),
        (12.0, 9.0, 5.0, 15.0),
        (12.0, 9.0, -8.0, -10.0),
        (9.0, 12.0, 4.0, 3.0),
    )
    return lesson(
        "05",
        _nearest(l1, l2, arm.limits_deg[1]),
        _forward(poses),
        _eq5(points),
        _eq6(points),
        _other_elbow(),
        _one_degree(l1, l2),
    )


def _nearest(l1, l2, elbow_limits_deg):
    right = abs(l1 - l2)
    folded = math.hypot(*forward(l1, l2, 0.0, max(map(abs, elbow_limits_deg))))
    return dict(
        asks="How near to the shoulder can the hand come, limits left out?",
        answer=Number(
            right, 0.5, "mm",
            (
                Wrong(0.0, "the hand could touch the shoulder only if both links were equally long."),
                Wrong(l1 * l2, "a length times a length is an area. Fold the arm: what is left of the upper arm?"),
                Wrong(l1 + l2, "that is the arm stretched out: the farthest, not the nearest."),
                Wrong(l2, "that is the forearm alone. Fold it back along the upper arm: what is left?"),
                Wrong(math.hypot(l1, l2), "that is with the elbow at a right angle. Fold it wholly."),
                Wrong(l1 / l2, "a length divided by a length is no length. Fold the arm: what is left of the upper arm?"),
                Wrong(l1, "that is where the elbow is. Now fold the forearm back."),
                Wrong(-right, "a distance is not below zero."),
                Wrong(abs(l1**2 - l2**2) ** 0.5, "so far from the shoulder is a hand with a right angle at it. Fold the arm wholly, along its whole length: no root and no half is needed."),
                Wrong(l2 / l1, "a length divided by a length is no length. Fold the arm: what is left of the upper arm?"),
                Wrong((l1 + l2) / 2, "the mean of the two has no place here. Fold the forearm back along the upper arm: what is left?"),
                Wrong(folded, "that is where the stop of the elbow lets it come. Here the limits are left out."),
            ),
            f"{right:.0f} mm: the forearm lies folded along the upper arm.",
            known={"l1": l1, "l2": l2},
            ask="Fold the forearm back along the upper arm: what is left of it?",
            small="so near it cannot come. Fold the forearm back along the upper arm: what is left of it?",
            large="it can come nearer. Fold the forearm back along the upper arm: what is left of it?",
        ),
        hints=(
            "Fold the arm like a pocket knife.",
            "The forearm then points back along the upper arm, by its own length.",
            "nearest_mm = abs(l1 - ____)",
        ),
        code="nearest_mm = abs(l1 - l2)",
        reason="Folded, the second link takes its length off the first.",
        reference=right,
    )  # fmt: skip


def _forward(poses):
    return dict(
        asks="Write forward kinematics: from the two angles to the place of the hand.",
        answer=Function(
            forward, poses, 0.01, "mm",
            (
                Wrong(
                    lambda a, b, s, t: (a * math.cos(s * DEGREE) + b * math.cos(t * DEGREE),
                                        a * math.sin(s * DEGREE) + b * math.sin(t * DEGREE)),
                    "θ2 is counted from the upper arm, not from the x axis. The forearm points to θ1 + θ2.",
                ),
                Wrong(
                    lambda a, b, s, t: (a * math.cos(s) + b * math.cos(s + t), a * math.sin(s) + b * math.sin(s + t)),
                    "math.cos counts in radians. Turn the degrees into radians first.",
                ),
                Wrong(
                    lambda a, b, s, t: ((a + b) * math.cos((s + t) * DEGREE), (a + b) * math.sin((s + t) * DEGREE)),
                    "only the forearm points to θ1 + θ2. Two walks, each with a direction of its own.",
                ),
                Wrong(
                    lambda a, b, s, t: forward(a, b, math.degrees(s) / DEGREE, math.degrees(t) / DEGREE),
                    "degrees() goes the wrong way: radians() makes radians of degrees.",
                ),
                Wrong(
                    lambda a, b, s, t: (a * math.sin(s * DEGREE) + b * math.sin((s + t) * DEGREE),
                                        a * math.cos(s * DEGREE) + b * math.cos((s + t) * DEGREE)),
                    "x and y are swapped: at 0 degrees the arm points along x.",
                ),
                Wrong(lambda a, b, s, t: _walks(a, s, b, t, 1.0), "math.cos counts in radians; and the forearm points to θ1 + θ2, not to θ2."),
                Wrong(lambda a, b, s, t: _walks(a, s, b, t - s), "a difference of the two angles. The forearm points to θ1 + θ2."),
                Wrong(lambda a, b, s, t: _walks(a, s, b, 180 - t), "180° − θ2 is the triangle's own angle. The forearm points to θ1 + θ2."),
                Wrong(lambda a, b, s, t: _walks(a, s, b, s + 180 - t), "the forearm points to θ1 + 180° − θ2, by this sum or by two minus signs: 180° − θ2 is the triangle's own angle. It points to θ1 + θ2, and its way is added."),
                Wrong(lambda a, b, s, t: _walks(a, s, b, s * t), "the two angles are added, not multiplied: θ1 + θ2."),
                Wrong(lambda a, b, s, t: _walks(a, s, b, s + t / DEGREE), "θ2 is still in degrees where you add it: put both into the brackets of radians."),
                Wrong(lambda a, b, s, t: _walks(a, s, b, t)[::-1], "sine and cosine have changed places: cosine in x, sine in y. And the forearm points to θ1 + θ2."),
                Wrong(lambda a, b, s, t: (forward(a, b, s, t)[0], _walks(a, s, b, t)[1]), "x is right. In y, too, the forearm points to θ1 + θ2."),
                Wrong(lambda a, b, s, t: (_walks(a, s, b, t)[0], forward(a, b, s, t)[1]), "y is right. In x, too, the forearm points to θ1 + θ2."),
                Wrong(lambda a, b, s, t: tuple(DEGREE * w for w in _walks(a, s, b, s + t, 1.0)), "the angles are to be turned into radians, inside cos and sin. A place is in mm."),
                Wrong(lambda a, b, s, t: _walks(a, s, a, s + t), "the forearm has its own length: l2."),
                Wrong(lambda a, b, s, t: _walks(b, s, a, s + t), "either the two lengths have changed places, or the two directions: the upper arm, l1, points to θ1."),
                Wrong(lambda a, b, s, t: _walks(a, t, b, s + t), "the upper arm points to θ1."),
                Wrong(lambda a, b, s, t: _walks(a, s, -b, s + t), "the forearm points backwards: by 180° too many, or by a minus before l2. It points to θ1 + θ2, and its way is added."),
                Wrong(lambda a, b, s, t: (forward(a, b, s, t)[0],) * 2, "x is the cosines, y the sines. Both of yours are x."),
                Wrong(lambda a, b, s, t: (forward(a, b, s, t)[0], _walks(a, s, 0, 0)[1] + _walks(0, 0, b, s + t)[0]), "in y both walks take a sine; yours has a cosine for the forearm."),
                Wrong(lambda a, b, s, t: (_walks(a, s, 0, 0)[0] + _walks(0, 0, b, s + t)[1], _walks(a, s, 0, 0)[1] + _walks(0, 0, b, s + t)[0]), "for the forearm sine and cosine have changed places: cosine in x, sine in y, for both links."),
                Wrong(lambda a, b, s, t: _walks(1, s, 1, s + t), "the lengths are missing: l1 times the one, l2 times the other."),
                Wrong(lambda a, b, s, t: _walks(a + b, s, 0, 0), "that is the stretched arm. The forearm points to θ1 + θ2: two walks."),
                Wrong(lambda a, b, s, t: (_walks(a, s, 0, 0)[0] * _walks(b, t, 0, 0)[0], _walks(a, s, 0, 0)[1] * _walks(b, t, 0, 0)[1]), "the two walks are added, one after the other: plus. And the forearm points to θ1 + θ2."),
                Wrong(
                    lambda a, b, s, t: (a * math.cos(s * DEGREE), a * math.sin(s * DEGREE)),
                    "that is the elbow. The forearm is still missing.",
                ),
                Wrong(
                    lambda a, b, s, t: (b * math.cos((s + t) * DEGREE), b * math.sin((s + t) * DEGREE)),
                    "that is the forearm alone. It starts at the elbow: add the way there.",
                ),
                Wrong(
                    lambda a, b, s, t: forward(a, b, s, -t),
                    "the forearm points to θ1 + θ2, not to θ1 − θ2: plus is counter-clockwise for both.",
                ),
            ),
            "the elbow first, then the forearm on top of it.",
        ),
        hints=(
            "Walk along the upper arm to the elbow, then along the forearm to the hand.",
            "A walk of length L in the direction a moves you by L·cos a in x and L·sin a in y.",
            "a, b = radians(theta1_deg), radians(theta1_deg + theta2_deg)\n    return l1 * cos(a) + l2 * cos(b), l1 * sin(a) + ____",
        ),
        code=(
            "def hand_mm(l1, l2, theta1_deg, theta2_deg):\n"
            "    a, b = radians(theta1_deg), radians(theta1_deg + theta2_deg)\n"
            "    return l1 * cos(a) + l2 * cos(b), l1 * sin(a) + l2 * sin(b)"
        ),
        reason="The elbow lies l1 in the direction θ1, the hand l2 farther in the direction θ1 + θ2.",
        reference=forward,
    )  # fmt: skip


def _eq5(points):
    return dict(
        asks="Write Eq. 5: the angle of the elbow that brings the hand to (x, y).",
        answer=Function(
            elbow_deg, points, 0.01, "degrees",
            (
                Wrong(lambda a, b, x, y: elbow_deg(a, b, x, y) * DEGREE, "that is in radians. The arm counts in degrees."),
                Wrong(
                    lambda a, b, x, y: 180 - elbow_deg(a, b, x, y),
                    "that is the inner angle of the triangle. θ2 is counted from the stretched arm: look at the sign.",
                ),
                Wrong(lambda a, b, x, y: elbow_deg(a, b, x, y) * DEGREE * DEGREE, "acos gives radians; degrees() turns them into degrees, radians() goes the other way."),
                Wrong(lambda a, b, x, y: 90 - elbow_deg(a, b, x, y), "that is asin. Eq. 5 takes acos."),
                Wrong(lambda a, b, x, y: 360 - elbow_deg(a, b, x, y), "all the way round the other side. θ2 runs from 0 to 180 here."),
                Wrong(lambda a, b, x, y: math.cos(_cosine(a, b, x, y)), "the fraction is the cosine already. Take its acos, the way back."),
                Wrong(lambda a, b, x, y: _cosine(a, b, x, y) / DEGREE, "that is cos θ2, turned into degrees as if it were an angle. Take its acos first."),
                Wrong(lambda a, b, x, y: math.cos(_cosine(a, b, x, y)) / DEGREE, "the fraction is the cosine already. Take its acos, the way back."),
                Wrong(lambda a, b, x, y: 1 / math.cos(_cosine(a, b, x, y)) / DEGREE, "arccos is not one over cos. It is the way back: acos."),
                Wrong(lambda a, b, x, y: math.atan(_cosine(a, b, x, y)) / DEGREE, "that is an arctangent. Eq. 5 takes acos: the fraction is a cosine, not a slope."),
                Wrong(lambda a, b, x, y: math.acos((x * x + y * y) / (2 * a * b)) / DEGREE, "above the line the squares of both links are missing: - l1**2 - l2**2."),
                Wrong(lambda a, b, x, y: math.acos((2 * x + 2 * y - 2 * a - 2 * b) / (2 * a * b)) / DEGREE, "*2 doubles. Squared is **2."),
                Wrong(lambda a, b, x, y: math.acos((x + y - a - b) / (2 * a * b)) / DEGREE, "the squares are missing above the line: **2, four times."),
                Wrong(lambda a, b, x, y: math.acos(math.hypot(x, y) / (a + b)) / DEGREE, "that is an angle, but not of this triangle. Eq. 5 stands above the cell."),
                Wrong(lambda a, b, x, y: math.acos(((x + y) ** 2 - a * a - b * b) / (2 * a * b)) / DEGREE, "square x and y each by itself, then add: x**2 + y**2."),
                Wrong(lambda a, b, x, y: 90 + elbow_deg(a, b, x, y), "a right angle too many. Eq. 5 gives θ2 as it stands."),
                Wrong(lambda a, b, x, y: math.atan2(y, x) / DEGREE, "that is the direction of the point; Eq. 6 needs it. The elbow hangs on its distance alone."),
                Wrong(lambda a, b, x, y: _cosine(a, b, x, y), "that is cos θ2. Take its acos."),
                Wrong(
                    lambda a, b, x, y: math.degrees(math.acos((x**2 + y**2 - a**2 + b**2) / (2 * a * b))),
                    "both squares are taken off: − l1² − l2².",
                ),
                Wrong(
                    lambda a, b, x, y: math.degrees(math.acos(max(-1, min(1, _cosine(a, b, x, y) / 2)))),
                    "only l1·l2 stands under the line once; Eq. 5 has 2·l1·l2 there.",
                ),
            ),
            "the elbow depends on the distance of the point alone, not on its direction.",
            domain=(
                "acos got a number outside −1…1, for a point that is in reach. "
                "Are all four squared above the line? Do l1 and l2 stand there by their names? (Other arms are tried as well.) "
                "Look at the signs, and at the brackets round 2 * l1 * l2, a product, and round everything above the line. degrees() comes last, outside acos."
            ),
        ),
        hints=(
            "Eq. 5 stands above the cell.",
            "acos gives radians; degrees() turns them into degrees.",
            "return degrees(acos((x**2 + y**2 - l1**2 - ____) / (2 * l1 * l2)))",
        ),
        code=(
            "def elbow_deg(l1, l2, x, y):\n"
            "    return degrees(acos((x**2 + y**2 - l1**2 - l2**2) / (2 * l1 * l2)))"
        ),
        reason="The cosine rule in the triangle of shoulder, elbow and hand, with the outer angle at the elbow.",
        reference=elbow_deg,
    )  # fmt: skip


def _eq6(points):
    tries = (*((*p, elbow_deg(*p)) for p in points), (*points[1], -elbow_deg(*points[1])))  # the last with the elbow up
    return dict(
        asks="Write Eq. 6: the angle of the shoulder, once the elbow is known.",
        answer=Function(
            shoulder_deg, tries, 0.01, "degrees",
            (
                Wrong(lambda a, b, x, y, t: math.degrees(math.atan2(y, x)) - abs(_lead(a, b, t)), "with the elbow up θ2 is below zero, and the upper arm leans to the other side: keep its sign."),
                Wrong(
                    lambda a, b, x, y, t: math.degrees(math.atan2(y, x)) - _by_sines(b, x, y, t),
                    "asin gives no angle above 90°: it cannot tell 65° from 115°, which have the same sine. Near the shoulder "
                    "the hand is ahead by more than 90°. atan2 of both parts, l2·sin θ2 and l1 + l2·cos θ2, tells the two apart.",
                ),
                Wrong(lambda a, b, x, y, t: math.degrees(math.atan2(y, x)) + _by_sines(b, x, y, t), "the shoulder must hold back: minus. And asin gives no angle above 90°, which the second part may have: take atan2 of l2·sin θ2 and l1 + l2·cos θ2."),
                Wrong(lambda a, b, x, y, t: math.atan2(y, x) - _by_sines(b, x, y, t) * DEGREE, "that is in radians. And asin gives no angle above 90°, which the second part may have: take atan2 of l2·sin θ2 and l1 + l2·cos θ2."),
                Wrong(lambda *t: shoulder_deg(*t) % 360, "the same direction, told the long way round: for the arm clockwise is below zero. Leave the % away."),
                Wrong(lambda *t: shoulder_deg(*t) * DEGREE, "that is in radians. The arm counts in degrees."),
                Wrong(
                    lambda a, b, x, y, t: math.degrees(math.atan2(y, x)) + _lead(a, b, t),
                    "the forearm turns the hand on by the second angle, so the shoulder must hold back: minus.",
                ),
                Wrong(
                    lambda a, b, x, y, t: math.degrees(math.atan2(y, x)) - t,
                    "that takes off the elbow's whole angle. The hand is ahead by only a part of it: the second term of Eq. 6.",
                ),
                Wrong(
                    lambda a, b, x, y, t: math.degrees(math.atan2(y, x) - t),
                    "θ2 is in degrees, and atan2 gives radians. And the hand is ahead by only a part of θ2: the second term of Eq. 6.",
                ),
                Wrong(lambda a, b, x, y, t: math.atan2(y, x) - math.atan2(b * math.sin(t), a + b * math.cos(t)), "sin and cos got degrees, and your result is in radians. Turn θ2 into radians first, and the result into degrees."),
                Wrong(lambda a, b, x, y, t: math.atan2(y, x) - _lead(a, b, t), "the first part is in radians, the second in degrees. Turn both."),
                Wrong(lambda a, b, x, y, t: shoulder_deg(a, b, x, y, t) * DEGREE**2, "atan2 gives radians; degrees() turns them into degrees, radians() goes the other way."),
                Wrong(lambda a, b, x, y, t: math.degrees(math.atan2(y, x)) - _lead(a, b, t / DEGREE**2), "degrees() goes the wrong way for θ2: sin and cos want radians(theta2_deg)."),
                Wrong(lambda a, b, x, y, t: math.degrees(math.atan2(y, x) - _second(b, a, b, t, factor=True)), "in the second part only l2 is taken times cos θ2: l1 + l2·cos θ2, no brackets round the sum."),
                Wrong(lambda a, b, x, y, t: math.degrees(math.atan2(y, x) - _second(b, 0, a, t)), "in the second part a plus is missing: l1 + l2·cos θ2."),
                Wrong(lambda a, b, x, y, t: math.degrees(math.atan2(y, x) - _second(a, a, b, t)), "the forearm is what turns the hand: l2·sin θ2, not l1."),
                Wrong(lambda a, b, x, y, t: math.degrees(math.atan2(y, x) - math.atan(b * math.sin(t * DEGREE) / a + b * math.cos(t * DEGREE))), "brackets are missing below the line; and atan2, with a comma, needs no line at all."),
                Wrong(lambda a, b, x, y, t: math.degrees(math.atan2(y, x) - math.atan2(b + math.sin(t * DEGREE), a + b * math.cos(t * DEGREE))), "l2 times sin θ2, not plus."),
                Wrong(lambda a, b, x, y, t: math.degrees(math.atan2(y - b * math.sin(t * DEGREE), x - a - b * math.cos(t * DEGREE))), "two angles are subtracted, not two places: atan2 of the point, minus atan2 of the second part."),
                Wrong(lambda a, b, x, y, t: math.degrees(math.atan2(y - b * math.sin(t * DEGREE), x - a + b * math.cos(t * DEGREE))), "two angles are subtracted, not two places: atan2 of the point, minus atan2 of the second part."),
                Wrong(lambda a, b, x, y, t: math.degrees(math.atan(y / x) - math.atan(b * math.sin(t * DEGREE) / (a + b * math.cos(t * DEGREE)))), "atan cannot tell left from right, in either place. Use atan2, with a comma."),
                Wrong(lambda a, b, x, y, t: math.degrees(math.atan2(y, x) - math.atan2(b * math.sin(t * DEGREE), a + b) * math.cos(t * DEGREE)), "a bracket closes too early: l1 + l2·cos θ2 is one whole, inside the second atan2."),
                Wrong(lambda a, b, x, y, t: math.degrees(math.atan2(y, x) - math.atan2(b * math.sin(t * DEGREE), a + b + math.cos(t * DEGREE))), "l2 times cos θ2, not plus."),
                Wrong(lambda a, b, x, y, t: math.degrees(math.atan2(y, x) - math.atan2(b * math.sin(t * DEGREE), a + b)), "the forearm does not lie along the upper arm: l1 + l2·cos θ2."),
                Wrong(lambda a, b, x, y, t: math.degrees(math.atan2(y, x) - math.atan2(math.sin(t * DEGREE), a + b * math.cos(t * DEGREE))), "l2 is missing before the sine: l2·sin θ2."),
                Wrong(lambda a, b, x, y, t: math.degrees(math.atan2(y, x) * _lead(a, b, t) * DEGREE), "the two angles are subtracted: minus, not times."),
                Wrong(lambda a, b, x, y, t: math.degrees(math.tan(y / x) - math.tan(b * math.sin(t * DEGREE) / (a + b * math.cos(t * DEGREE)))), "arctan is the way back from a slope to an angle: atan2(y, x), not tan."),
                Wrong(lambda a, b, x, y, t: math.degrees(math.atan2(y, x) - b * math.sin(t * DEGREE) - a + b * math.cos(t * DEGREE)), "the second atan2 is missing: a length is taken from an angle."),
                Wrong(lambda a, b, x, y, t: math.degrees(math.atan2(y, x) - b * math.sin(t * DEGREE) - a - b * math.cos(t * DEGREE)), "the second atan2 is missing: a length is taken from an angle."),
                Wrong(
                    lambda a, b, x, y, t: math.degrees(math.atan2(x, y)) - _lead(a, b, t),
                    "atan2 takes y first, then x.",
                ),
                Wrong(
                    lambda a, b, x, y, t: math.degrees(math.atan(y / x)) - _lead(a, b, t),
                    "right in front of the shoulder, but atan cannot tell left from right. Use atan2(y, x).",
                ),
                Wrong(
                    lambda a, b, x, y, t: math.degrees(
                        math.atan2(y, x) - math.atan2(b * math.sin(t), a + b * math.cos(t))
                    ),
                    "sin and cos got degrees. Turn θ2 into radians first.",
                ),
                Wrong(
                    lambda a, b, x, y, t: math.degrees(math.atan2(y, x)) - _lead(a, b, t) * DEGREE,
                    "the first part is in degrees, the second in radians. Turn both.",
                ),
                Wrong(
                    lambda a, b, x, y, t: math.degrees(math.atan2(y, x) - math.atan2(b * math.cos(t * DEGREE), a + b * math.sin(t * DEGREE))),
                    "sin and cos have changed places in the second part: l2·sin θ2 first, then l1 + l2·cos θ2.",
                ),
                Wrong(
                    lambda a, b, x, y, t: math.degrees(math.atan2(y, x) - math.atan2(a + b * math.cos(t * DEGREE), b * math.sin(t * DEGREE))),
                    "in the second atan2 the two parts have changed places: l2·sin θ2 comes first.",
                ),
                Wrong(
                    lambda a, b, x, y, t: math.degrees(math.atan2(y, x) - math.atan2(b * math.sin(t * DEGREE), a - b * math.cos(t * DEGREE))),
                    "plus in the second part: l1 + l2·cos θ2.",
                ),
                Wrong(
                    lambda a, b, x, y, t: math.degrees(math.atan2(y, x) - b * math.sin(t * DEGREE) / (a + b * math.cos(t * DEGREE))),
                    "the fraction is a slope, no angle: take atan2 of its two parts.",
                ),
                Wrong(
                    lambda a, b, x, y, t: math.degrees(math.atan2(y, x)),
                    "that is the direction of the point. The bent forearm needs the second term.",
                ),
            ),
            "the direction of the point, minus what the bent elbow adds.",
        ),
        hints=(
            "Eq. 6 has two parts: where the point is, and what the elbow adds.",
            "atan2(y, x) is the direction of the point. sin and cos need radians.",
            "t = radians(theta2_deg)\n    return degrees(atan2(y, x) - atan2(l2 * sin(t), l1 + l2 * ____))",
        ),
        code=(
            "def shoulder_deg(l1, l2, x, y, theta2_deg):\n"
            "    t = radians(theta2_deg)\n"
            "    return degrees(atan2(y, x) - atan2(l2 * sin(t), l1 + l2 * cos(t)))"
        ),
        reason="Seen from the shoulder, the hand stands atan2(l2·sin θ2, l1 + l2·cos θ2) ahead of the upper arm.",
        reference=shoulder_deg,
    )  # fmt: skip


def _other_elbow():
    return dict(
        asks="One pose has its elbow at θ2 = 70°. What is θ2 in the other pose that reaches the same point?",
        answer=Number(
            -70.0, 0.01, "degrees",
            (
                Wrong(70.0, "that is the same elbow again."),
                Wrong(110.0, "that is the inner angle of the triangle."),
                Wrong(-110.0, "mirrored, yes; but θ2 is counted from the stretched arm, so it is 70° again, with a minus."),
                Wrong(250.0, "that is −110° told the other way. Counted from the stretched arm the mirror image has −70°."),
                Wrong(20.0, "that is what is left to a right angle. The other elbow is a mirror image."),
                Wrong(-20.0, "that is what is left to a right angle. The other elbow is a mirror image."),
                Wrong(0.0, "that is the stretched arm: it reaches the rim alone. The other elbow is a mirror image."),
                Wrong(70 * DEGREE, "that is 70° in radians. The arm counts in degrees, and the other elbow is not the same one."),
                Wrong(math.cos(70 * DEGREE), "that is the cosine of 70°. Which other angle has the same cosine?"),
                Wrong(-290.0, "that is 70° again, told the other way round: the same elbow."),
                Wrong(430.0, "that is 70° again, after a whole turn: the same elbow."),
                Wrong(-250.0, "that is 110°, the inner angle of the triangle, told the other way round."),
                Wrong(160.0, "a right angle more. The other elbow is a mirror image at the line from shoulder to hand."),
                Wrong(180.0, "that is the folded arm: it reaches the nearest places alone. The other elbow is a mirror image."),
                Wrong(-180.0, "that is the folded arm: it reaches the nearest places alone. The other elbow is a mirror image."),
                Wrong(90.0, "that is a right angle: with it the hand is at another distance. The other elbow is a mirror image."),
                Wrong(-90.0, "that is a right angle: with it the hand is at another distance. The other elbow is a mirror image."),
                Wrong(360.0, "that is the stretched arm, after a whole turn. The other elbow is a mirror image."),
                Wrong(-70 / DEGREE, "that is taken for radians and turned into degrees. Write the degrees as they are."),
                Wrong(-70 * DEGREE, "that is in radians. The arm counts in degrees."),
                Wrong(290.0, "that is the same direction as −70°, but the joint would have to turn there through 180°."),
            ),
            "mirrored at the line from the shoulder to the hand.",
            known={"70": 70, "90": 90, "180": 180, "360": 360},
            beside=(
                ("(elbow )?(up|down)", "that is its name. How many degrees has θ2 in it?"),
                ("negative|minus|mirrored|the opposite", "yes, and how many degrees?"),
                (r"70\W*(degrees\W*)?(but |with |on )*(a |the )?(negative|minus|mirrored|other (way|side))", "yes. Write it as a number, with its sign."),
                ("(the )?same", "the same θ2 is the same elbow. The other one is its mirror image: how many degrees?"),
            ),
            ask="In the other pose the arm is its own mirror image, at the line from shoulder to hand. How is θ2 counted there?",
        ),
        hints=(
            "In the triangle above, draw the arm with its elbow on the other side of the dashed line: a mirror image.",
            "acos gives one angle; which other angle has the same cosine?",
            "theta2_up_deg = -____",
        ),
        code="theta2_up_deg = -70",
        reason="cos θ2 = cos(−θ2): Eq. 5 cannot tell the two apart.",
        reference=-70.0,
    )  # fmt: skip


def _one_degree(l1, l2):
    reach = l1 + l2
    right = reach * DEGREE
    return dict(
        asks="The arm is stretched out and its shoulder is off by 1°. By how many millimetres is the hand off?",
        answer=Number(
            right, 0.02 * right, "mm",
            (
                Wrong(
                    reach,
                    "that is the length of the arm: so far the hand goes for a whole radian, 57 degrees. (cos looks along the arm, "
                    "and the hand goes across it.)",
                ),
                Wrong(reach / 180, "half a turn has π radians: a factor of π is missing."),
                Wrong(1.0, "a degree is not a millimetre: it is worth more, the longer the arm."),
                Wrong(2 * right, "once the reach times one degree in radians; you have it twice."),
                Wrong(reach * math.sin(1), "sin counts in radians: this is the sine of 57 degrees."),
                Wrong(l2 * DEGREE, "that is the forearm alone. Round the shoulder turns the whole arm."),
                Wrong(abs(l1 - l2) * DEGREE, "that is the folded arm. This one is stretched out: l1 + l2."),
                Wrong(reach / 360, "a circle is 2·π·r long: 2·π is missing."),
                Wrong(2 * reach * math.pi, "that is the whole circle, 360 degrees."),
                Wrong(math.radians(1), "that is one degree in radians. Times the length of the arm."),
                Wrong(reach * math.degrees(1), "degrees() goes the other way: from radians to degrees. Take radians(1)."),
                Wrong(reach * math.cos(1), "cos counts in radians, and looks along the arm. The hand goes across it, along a circle."),
                Wrong(reach * (1 - math.cos(DEGREE)), "that is how much nearer it comes along the arm. The hand goes across it, along a circle."),
                Wrong(reach * math.tan(1), "tan counts in radians: this is the tangent of 57 degrees."),
                Wrong(reach * math.pi, "that is half a turn, 180 degrees. One degree is asked for."),
                Wrong(math.hypot(l1, l2) * DEGREE, "that is with the elbow at a right angle. Stretched out, the arm is l1 + l2 long."),
                Wrong(l1 + l2 * DEGREE, "brackets are missing: (l1 + l2) first, then times the angle."),
                Wrong(reach * math.cos(DEGREE), "cos looks along the arm. The hand goes across it, along a circle."),
                Wrong(l1 + l2 - DEGREE, "a length and an angle are not subtracted. An arc is its radius times its angle in radians."),
                Wrong(l1 + l2 + DEGREE, "a length and an angle are not added. An arc is its radius times its angle in radians."),
                Wrong(DEGREE / reach, "times the length, not divided by it."),
                Wrong(reach**2 * DEGREE, "the length counts once: an arc, not an area."),
                Wrong(math.pi * reach**2 / 360, "that is an area, a slice of the circle. How long is its rim?"),
                Wrong(l1 * l2 * DEGREE, "the links are added, not multiplied: the arm is l1 + l2 long."),
                Wrong(l1 * DEGREE + 2 * l2 * DEGREE, "the elbow is not off; only the shoulder is. The arm turns as one piece, l1 + l2 long."),
                Wrong(reach * math.radians(90), "that is for 90 degrees. One is asked for."),
                Wrong(reach / 100, "that is for a hundredth of a radian. One degree is 0.0175."),
                Wrong(1 / 360, "that is what part of a turn one degree is. Of which way does the hand go that part?"),
                Wrong(reach / 1000, "that is for a thousandth of a radian. One degree is 0.0175."),
                Wrong(l1 * DEGREE, "that is by how much the elbow is off. The hand is farther out."),
            ),
            f"{right:.1f} mm for a single degree.",
            known={"l1": l1, "l2": l2, "radians(1)": DEGREE},
            ask="The hand goes along a circle round the shoulder: how long is its whole rim, and what part of it is one degree?",
            small="so far it goes for less than one degree. How long is the whole circle, and what part of it is one degree?",
            large="so far it goes for more than one degree. How long is the whole circle, and what part of it is one degree?",
        ),
        hints=(
            "The hand moves along a circle round the shoulder.",
            "The whole circle is 2·π·r long and has 360 degrees.",
            "off_mm = (l1 + l2) * ____   # one degree, in radians",
        ),
        code="off_mm = (l1 + l2) * radians(1)",
        reason="An arc is its radius times its angle in radians.",
        reference=right,
    )  # fmt: skip


def forward(l1: float, l2: float, theta1_deg: float, theta2_deg: float) -> tuple[float, float]:
    """The hand in mm."""
    a, b = theta1_deg * DEGREE, (theta1_deg + theta2_deg) * DEGREE
    return l1 * math.cos(a) + l2 * math.cos(b), l1 * math.sin(a) + l2 * math.sin(b)


def elbow_deg(l1: float, l2: float, x: float, y: float) -> float:
    """Eq. 5, degrees; a point out of reach has no angle and raises ValueError, as acos does."""
    cosine = _cosine(l1, l2, x, y)
    return math.degrees(math.acos(round(cosine, 12) if abs(cosine) > 1 else cosine))


def shoulder_deg(l1: float, l2: float, x: float, y: float, theta2_deg: float) -> float:
    """Eq. 6, degrees."""
    return math.degrees(math.atan2(y, x)) - _lead(l1, l2, theta2_deg)


def _walks(first, to_deg, second, then_deg, unit=DEGREE):
    """Two walks, each with its own direction: where they end."""
    a, b = to_deg * unit, then_deg * unit
    return first * math.cos(a) + second * math.cos(b), first * math.sin(a) + second * math.sin(b)


def _second(up, straight, on, theta2_deg, factor=False):
    """The second atan2 of Eq. 6 with other lengths in its places; ``factor``: the cosine taken times the whole sum."""
    t = theta2_deg * DEGREE
    right = (straight + on) * math.cos(t) if factor else straight + on * math.cos(t)
    return math.atan2(up * math.sin(t), right)


def _by_sines(l2, x, y, theta2_deg):
    """What the hand is ahead by the sine rule, degrees: right up to 90."""
    return math.degrees(math.asin(l2 * math.sin(theta2_deg * DEGREE) / math.hypot(x, y)))


def _cosine(l1, l2, x, y):
    return (x**2 + y**2 - l1**2 - l2**2) / (2 * l1 * l2)


def _lead(l1, l2, theta2_deg):
    t = theta2_deg * DEGREE
    return math.degrees(math.atan2(l2 * math.sin(t), l1 + l2 * math.cos(t)))
