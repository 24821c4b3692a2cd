"""The drawings and the page on building: what is drawn fits together, and weighs what the kit counts with."""

import csv
import math
import re
from dataclasses import replace

import pytest

from conftest import ROOT
from stereo_lab.arm.virtual import BENCH_ARM, BENCH_MOTORS, END_STOPS_DEG, SWITCHES_DEG
from stereo_lab.firmware import drawings
from stereo_lab.kinematics import KGF_CM, ArmWeight, JointAngles, moments_g_mm, worst_torque_nm

PAGE = (ROOT / "stereo_lab/firmware/README.md").read_text(encoding="utf-8")
PLYWOOD_G_MM3 = 0.7e-3  # birch
WASHER_MM = 1.0


@pytest.mark.parametrize("name", ["front.svg", "layers.svg", "template.svg", "template.html"])
def test_drawings_are_those_of_the_script(name, tmp_path):
    drawings.main(tmp_path)
    drawn = (ROOT / f"stereo_lab/firmware/{name}").read_text(encoding="utf-8")
    assert (tmp_path / name).read_text(encoding="utf-8") == drawn, "run stereo_lab/firmware/drawings.py"


def test_the_sheets_cover_the_template_once():
    """Edge on edge, each as large as its part of the drawing is: a millimetre is a millimetre."""
    page = (ROOT / "stereo_lab/firmware/template.html").read_text(encoding="utf-8")
    parts = re.findall(
        r'width="([\d.]+)mm" height="([\d.]+)mm" role="img" viewBox="([\d.]+) ([\d.]+) ([\d.]+) ([\d.]+)"', page
    )
    whole = (ROOT / "stereo_lab/firmware/template.svg").read_text(encoding="utf-8")
    wide, high = map(float, re.search(r'viewBox="0 0 ([\d.]+) ([\d.]+)"', whole).groups())
    places = {(float(x), float(y)) for *_, x, y, _, _ in parts}
    across, down = drawings.SHEET_MM
    assert all((w, h) == (a, b) for w, h, _, _, a, b in parts) and len(places) == len(parts)
    assert places == {
        (x * across, y * down) for x in range(math.ceil(wide / across)) for y in range(math.ceil(high / down))
    }
    assert across <= min(210, 216) - 20 and down <= min(297, 279) - 20 - 8  # of A4 and Letter, with a line of words
    for x, y, radius in re.findall(r'<circle cx="([\d.]+)" cy="([\d.]+)" r="([\d.]+)"', whole):
        for at, part in ((float(x), across), (float(y), down)):
            assert (at - float(radius)) // part == (at + float(radius)) // part, "a hole is cut"


def test_pegs_meet_at_the_end_stops():
    """Two pegs touch when their middles are one diameter apart: at both ends of the range, and nowhere between."""
    for low, high in END_STOPS_DEG:
        radius, fixed = drawings.peg_circle_mm((low, high)), drawings.fixed_peg_deg((low, high))
        apart = [math.dist(drawings.around(radius, a), drawings.around(radius, fixed)) for a in (low, high)]
        assert apart == pytest.approx([drawings.PEG_MM] * 2, abs=0.01)
        between = [
            math.dist(drawings.around(radius, a), drawings.around(radius, fixed))
            for a in range(int(low) + 1, int(high))
        ]
        assert min(between) > drawings.PEG_MM


@pytest.mark.parametrize(("arm", "dollars"), [("DC", 90), ("servo", 70)])
def test_the_parts_are_as_cheap_as_the_page_says(arm, dollars):
    with (ROOT / "stereo_lab/firmware/parts.csv").open(encoding="utf-8", newline="") as file:
        rows = [row for row in csv.DictReader(file) if row["arm"] == arm]
    total = sum(int(row["count"]) * float(row["usd_each"]) for row in rows)
    assert total < dollars and all(row["seller"] and row["checked"] in ("yes", "not checked") for row in rows)
    assert f"{'costs' if arm == 'DC' else 'for'} {total:.0f} dollars" in PAGE


def reach(depths):
    return depths[1] - depths[0]


def test_nothing_runs_through_a_belt():
    """From the board to the cameras: pulleys of the shoulder, their belt in them, those of the elbow, link 1, link 2."""
    d = drawings
    assert d.SHOULDER_PULLEYS[0] < d.SHOULDER_BELT[0] and d.SHOULDER_BELT[1] < d.SHOULDER_PULLEYS[1]
    assert d.SHOULDER_PULLEYS[1] < d.ELBOW_PULLEYS[0] < d.ELBOW_BELT[0] < d.ELBOW_BELT[1] < d.ELBOW_PULLEYS[1]
    assert d.ELBOW_PULLEYS[1] < d.LINK_1[0] < d.LINK_1[1] < d.LINK_2[0]
    on_board, on_link = d.SHOULDER_PEGS
    assert on_board[1] + 1 < d.ELBOW_BELT[0]  # the belt of the elbow swings over it
    assert on_link[0] - 2 > d.SHOULDER_BELT[1]  # and this one swings over the belt of the shoulder
    assert d.SHOULDER_SWITCH[1] < d.ELBOW_BELT[0]
    radius, tail = d.peg_circle_mm(END_STOPS_DEG[0]), d.tail_mm(BENCH_ARM)
    small, large = d.pulley_radius_mm(d.SMALL_PULLEY), d.pulley_radius_mm(d.LARGE_PULLEY)
    strand = small + (large - small) * (tail + radius) / (tail + BENCH_ARM.l1_mm)
    assert strand > d.PEG_MM / 2 + 5  # the peg of link 1 passes between the strands of its belt
    assert radius - d.PEG_MM / 2 > large + 2


@pytest.mark.parametrize(
    ("pegs", "long_mm", "plates", "washers"),
    [
        (drawings.SHOULDER_PEGS, 35, (drawings.FRONT_BOARD, drawings.LINK_1), (3, 2)),
        (drawings.ELBOW_PEGS, 16, (drawings.LINK_1, drawings.ELBOW_DOUBLER), (0, 0)),
    ],
)
def test_pegs_are_screws_that_are_sold_and_meet_beside_their_nuts(pegs, long_mm, plates, washers):
    behind, before = pegs
    assert [reach(peg) for peg in pegs] == [long_mm] * 2
    assert behind[0] == plates[0][0] - washers[0] * WASHER_MM and before[1] == plates[1][1] + washers[1] * WASHER_MM
    nut_mm = drawings.THIN_NUT_MM if pegs is drawings.ELBOW_PEGS else drawings.NUT_MM
    nearer = drawings.LINK_2 if pegs is drawings.ELBOW_PEGS else drawings.LINK_1
    low, high = max(before[0], plates[0][1] + nut_mm + 1), min(behind[1], nearer[0] - nut_mm - 1)
    assert high - low >= 4
    if pegs is drawings.ELBOW_PEGS:  # its switch lies between the links, under the peg that turns
        switch = drawings.ELBOW_SWITCH
        assert switch[0] == drawings.LINK_1[1] + 1.5 and switch[1] + 1 < drawings.LINK_2[0] - drawings.THIN_NUT_MM
        assert before[0] <= sum(switch) / 2 + 1.8 - 2.5  # the lever is 3.6 wide: the shank lies across most of it
    else:
        assert before[0] <= sum(drawings.SHOULDER_SWITCH) / 2 + 1.8 - 2.5


@pytest.mark.parametrize(("j", "told_mm"), [(0, 5), (1, 2)])
def test_a_switch_is_set_by_the_gap_between_the_pegs(j, told_mm):
    radius, fixed = drawings.peg_circle_mm(END_STOPS_DEG[j]), drawings.fixed_peg_deg(END_STOPS_DEG[j])
    pegs = drawings.around(radius, SWITCHES_DEG[j]), drawings.around(radius, fixed)
    assert math.dist(*pegs) - drawings.PEG_MM == pytest.approx(told_mm, abs=0.05)
    assert f"{told_mm} mm between the" in PAGE


def test_the_links_weigh_what_the_kit_counts_with():
    weight, tail = ArmWeight(), drawings.tail_mm(BENCH_ARM)
    ends = drawings.LINK_MM / 2
    belt_and_peg = 16  # g, a little nearer to the elbow than the link's middle
    for told, center, back, front, depths in (
        (weight.link1_g - belt_and_peg, weight.center1_mm, tail + drawings.STEEL_MM, BENCH_ARM.l1_mm, drawings.LINK_1),
        (weight.link2_g, None, 0.0, BENCH_ARM.l2_mm, drawings.LINK_2),
    ):
        area = (front + back) * drawings.LINK_MM + math.pi * ends**2
        assert told == pytest.approx(area * reach(depths) * PLYWOOD_G_MM3, rel=0.05)
        assert center is None or center == pytest.approx((front - back) / 2, abs=1.5)
    assert weight.motor_at_mm == pytest.approx(-tail, abs=0.5)


def test_the_hand_weighs_what_the_page_says():
    """On a kitchen scale, both links level, before hand, ball and pegs are on: the moments of both, at the length of both."""
    bare = replace(BENCH_ARM, weight=ArmWeight(link1_g=93, hand_g=0, load_g=0))
    grams = sum(moments_g_mm(bare)) / sum((BENCH_ARM.l1_mm, BENCH_ARM.l2_mm))
    assert f"shows about {grams:.0f} g" in PAGE


def test_the_torques_that_the_page_tells_of_other_builds():
    bare = replace(BENCH_ARM, weight=ArmWeight(motor_g=103))
    factor = BENCH_MOTORS[0].rated_nm / worst_torque_nm(bare)[0]
    assert f"Without the steel the factor is\n{factor:.1f}" in PAGE
    servo = worst_torque_nm(replace(BENCH_ARM, weight=ArmWeight(elbow_g=75, motor_g=100)))[0] / KGF_CM
    assert f"says {servo:.1f} kgf·cm for the shoulder; the servo's rated torque is 6.5, {6.5 / servo:.1f} times" in PAGE


def test_link_2_keeps_off_the_shoulder_and_the_tail():
    """Folded up to its end stops: the spot at its end stays off the shoulder's hub, which reaches as far forward."""
    for stop in END_STOPS_DEG[1]:
        away = math.hypot(*BENCH_ARM.forward(JointAngles(0.0, stop)))
        assert away - drawings.LINK_MM / 2 > 16 + 10


def test_the_arm_hangs_off_the_table():
    height = 515
    assert f"{height} mm above the table" in PAGE
    assert height - sum((BENCH_ARM.l1_mm, BENCH_ARM.l2_mm)) - drawings.LINK_MM / 2 > 40


@pytest.mark.parametrize("j", [0, 1])
def test_the_peg_comes_across_the_lever_and_off_it_again(j):
    """From its switch's place to the end stop the peg presses the lever deeper, and five degrees before it the lever is free."""
    middle, along = drawings.switch_box(j)
    hinge, tip = (complex(*place) for place in drawings.lever(j))
    lever = (tip - hinge) / abs(tip - hinge)
    side = 1 if ((complex(*middle) - hinge) * lever.conjugate()).imag > 0 else -1

    def pressed_mm(angle):
        """How far the lever's free end gives way to the peg, from where the lever is drawn, towards the switch."""
        peg = complex(*drawings.around(drawings.peg_circle_mm(END_STOPS_DEG[j]), angle)) - hinge
        along_mm = (peg * lever.conjugate()).real
        beside = side * (peg * lever.conjugate()).imag
        assert along_mm > 2
        return (beside + drawings.PEG_MM / 2) * drawings.LEVER_MM / along_mm

    closes, stop = SWITCHES_DEG[j], END_STOPS_DEG[j][0]
    places = [pressed_mm(angle) for angle in (closes + 10, closes + 5, closes, (closes + stop) / 2, stop)]
    assert places == sorted(places)
    assert places[2] - places[1] > 0.3


def test_the_lever_keeps_off_the_fixed_peg():
    for j, nut_mm in ((0, 0.0), (1, 4.6)):  # the elbow's nut is as deep as the lever
        hinge = complex(*drawings.lever(j)[0])
        fixed = complex(
            *drawings.around(drawings.peg_circle_mm(END_STOPS_DEG[j]), drawings.fixed_peg_deg(END_STOPS_DEG[j]))
        )
        assert abs(fixed - hinge) > drawings.LEVER_MM + max(nut_mm, drawings.PEG_MM / 2)
