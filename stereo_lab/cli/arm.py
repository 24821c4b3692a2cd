"""``stereo-lab arm``: talk to an arm from the terminal."""

from __future__ import annotations

import argparse
import contextlib
import time

from stereo_lab.cli.options import Add, add_json, decimal, whole
from stereo_lab.cli.terminal import OK, end_as_by_ctrl_c, me, tell_fit, write_json_option
from stereo_lab.errors import ArmError, StereoLabError, UnreachableTargetError

MOST_WORDS = {"move": 2, "register": 1, "setup": 1}  # after an action; after any other none
OPTION_OF = {"left": "register", "right": "register", "keep": "register", "seconds": "monitor"}


def add_to(add: Add) -> None:
    """The commands and their options."""
    arm = add(
        "arm",
        run_arm,
        "Talk to an arm: list the ports, or name one and say what to do. Only home, move, calibrate and register move it; the last three home it first where it does not know where it stands.",
        "arm virtual://arm move 30 45",
    )
    arm.add_argument(
        "url", metavar="list|torque|URL",
        help="list: the ports; torque: what the arm of a recording weighs on its joints; or a port: virtual://arm, COM3, "
        "/dev/ttyUSB0, socket://…; feetech://PORT for bus servos",
    )  # fmt: skip
    arm.add_argument(
        "action", nargs="?", metavar="ACTION",
        help=f"{', '.join(ARM_ACTIONS)}, setup (default: status); after torque: folder or name of a recording",
    )  # fmt: skip
    arm.add_argument(
        "angles",
        nargs="*",
        default=[],
        metavar="WORD",
        help="for move: shoulder and elbow in degrees; for register: the recording",
    )
    arm.add_argument("--left", type=whole, metavar="N", help="for register: number of the left camera (0)")
    arm.add_argument("--right", type=whole, metavar="N", help="for register: number of the right camera (1)")
    arm.add_argument("--keep", action="store_true", default=None, help="for register: write it into the recording")
    arm.add_argument(
        "--seconds",
        type=decimal,
        default=None,
        metavar="S",
        help="for monitor: stop after so long (else Ctrl-C ends it, with exit code 0)",
    )
    add_json(arm)


def run_arm(options: argparse.Namespace) -> int:
    """List the ports, tell an arm's torque, or do one of ``ARM_ACTIONS`` with an arm. The exit code is OK."""
    from stereo_lab.arm import connect, ports

    action = options.url if options.url in ("list", "torque") else options.action or "status"
    if options.url in ARM_ACTIONS:
        raise StereoLabError(f"Name the port before {options.url}, as in: {me()} arm virtual://arm {options.url}")
    if action not in ("list", "torque", "setup", *ARM_ACTIONS):
        raise StereoLabError(f"There is no action {action!r}. Choose one of {', '.join(ARM_ACTIONS)}, setup.")
    _refuse_idle_words(action, options)
    if action == "torque":
        write_json_option(options.json, _arm_torque(options.action))
        return OK
    if action == "setup":
        return _arm_setup(options)
    if action == "list":
        for name, description in ports():
            print(f"{name:20s} {description}")
        write_json_option(options.json, [{"port": name, "description": text} for name, text in ports()])
        return OK
    end_as_by_ctrl_c()
    with connect(options.url) as arm:
        facts = ARM_ACTIONS[action](arm, options)
    write_json_option(options.json, facts)
    return OK


def _refuse_idle_words(action, options):
    """Words and options that an action has no use for: who gives them wants something else."""
    idle = [options.action] if action == "list" and options.action else []
    idle += options.angles if action not in MOST_WORDS else options.angles[MOST_WORDS[action] :]
    idle += [f"--{name}" for name, whose in OPTION_OF.items() if action != whose and getattr(options, name) is not None]
    if idle:
        raise StereoLabError(
            f"arm: {action} has no use for {', '.join(idle)}. `{me()} arm --help` tells what each takes."
        )


def _arm_setup(options):
    """Write into bus servos what they must know, one after the other."""
    from stereo_lab.arm.feetech.bus import Bus
    from stereo_lab.arm.feetech.port import open_bus
    from stereo_lab.arm.feetech.setup import set_up
    from stereo_lab.recording import open_recording

    if not options.url.startswith("feetech://"):
        raise StereoLabError(
            f"Only bus servos are set up, feetech://PORT; {options.url} keeps its numbers in the sketch."
        )
    limits = open_recording(options.angles[0] if options.angles else None).arm.limits_deg
    try:
        port = open_bus(options.url.removeprefix("feetech://").partition("?")[0])
    except (OSError, ValueError) as error:  # what pyserial raises is an OSError
        raise ArmError(f"{options.url} does not open: {error}. `stereo-lab arm list` names the ports.") from None
    with contextlib.closing(port):
        for joint, limit in enumerate(limits, start=1):
            print(f"Joint {joint}: plug in its servo alone, and its supply.")
            if not _asked("Is it plugged in?"):
                return OK
            bus = Bus(port)
            try:
                bus.find_echo(1)
                if not set_up(bus, joint, limit, _asked):
                    print("Nothing was written." if joint == 1 else "Joint 2 is left as it is.")
                    return OK
            except OSError as error:
                told = f"Joint {joint} is not set up ({error}). Is the adapter plugged in, and its supply on?"
                raise ArmError(told) from None
            print(f"Joint {joint} is set up.")
    return OK


def _asked(question):
    try:
        return input(f"{question} [y/N] ").strip().lower() in ("y", "yes")
    except EOFError:  # nobody there to answer
        return False


def _arm_torque(name):
    """What the weight of a recording's arm asks of its joints."""
    from stereo_lab.arm.virtual import BENCH_MOTORS
    from stereo_lab.kinematics import KGF_CM, holding_torque_nm, worst_poses, worst_torque_nm
    from stereo_lab.recording import open_recording

    arm = open_recording(name).arm
    w, rated = arm.weight, [motor.rated_nm for motor in BENCH_MOTORS]
    print(
        f"links {arm.l1_mm:g} and {arm.l2_mm:g} mm, {w.link1_g:g} and {w.link2_g:g} g; hand {w.hand_g:g} g, load {w.load_g:g} g"
    )
    print(f"{'':14s}{'at angles':>16s}{'holds':>12s}{'':>14s}   listed motor, rated over that")
    facts = {}
    for j, (joint, pose, worst) in enumerate(
        zip(("shoulder", "elbow"), worst_poses(arm), worst_torque_nm(arm), strict=True)
    ):
        angles = f"{pose.theta1_deg:g}, {pose.theta2_deg:g}"
        print(f"{joint:14s}{angles:>16s}{worst:8.3f} N·m{worst / KGF_CM:7.2f} kgf·cm   {rated[j] / worst:.1f} times")
        told = holding_torque_nm(arm, pose)
        facts[joint] = {"worst_nm": worst, "pose_deg": [pose.theta1_deg, pose.theta2_deg], "both_nm": list(told)}
        facts[joint]["rated_over_worst"] = rated[j] / worst
    return facts


def _arm_status(arm, options):
    status = arm.status()
    print(f"{arm.name}: {status.state}, joints at {_degrees(status.position_deg)}")
    if not all(status.homed):
        print("not homed since it was switched on: the angles count from where the joints stood then.")
    low_high = "; ".join(f"joint {k} turns from {low:g} to {high:g}" for k, (low, high) in enumerate(arm.limits_deg, 1))
    print(f"{low_high} degrees; supply {arm.supply_v[0]:g} and {arm.supply_v[1]:g} V")
    return {"state": status.state, "angles_deg": list(status.position_deg), "homed": list(status.homed)}


def _arm_home(arm, options):
    print("The arm moves: homing both joints …", flush=True)
    reached = arm.home()
    print(f"homed; joints at {_degrees((reached.theta1_deg, reached.theta2_deg))}; now its motors go off")
    return {"angles_deg": [reached.theta1_deg, reached.theta2_deg]}


def _arm_move(arm, options):
    from stereo_lab.arm import JointAngles
    from stereo_lab.common.files import finite_number

    if len(options.angles) != 2:
        raise StereoLabError(f"move: expected two angles, shoulder and elbow; got {len(options.angles)}.")
    goal = JointAngles(*(finite_number(word, f"move, joint {k}") for k, word in enumerate(options.angles, 1)))
    arm.goals_deg(goal)  # refuses what is out of range before anything moves
    _home_if_lost(arm)
    reached = arm.move_to(goal)
    print(f"reached {_degrees((reached.theta1_deg, reached.theta2_deg))}; now its motors go off")
    return {"angles_deg": [reached.theta1_deg, reached.theta2_deg]}


def _home_if_lost(arm):
    """Opening its port restarts an Arduino, and then the angles count from wherever the arm happens to stand."""
    if not arm.homed:
        print("The arm moves: it does not know where it stands, so it homes both joints …", flush=True)
        arm.home()


def _hang(arm):
    """With the end of a command its motors go off, and only where it hangs it cannot fall."""
    from stereo_lab.arm import JointAngles

    with contextlib.suppress(ArmError, UnreachableTargetError):  # it was stopped, or hanging is out of its range
        arm.move_to(JointAngles(-90, 0))
        print("The arm hangs; now its motors go off.")


def _arm_calibrate(arm, options):
    facts = {}
    _home_if_lost(arm)
    print("The arm moves: it is weighed, then each motor is pushed to and fro …", flush=True)
    for joint, fit in enumerate(arm.weigh(), start=1):
        print(f"joint {joint} is held by {fit.g1_v:.2f}·cos θ1 + {fit.g2_v:.2f}·cos(θ1 + θ2) V")
        facts[f"joint {joint} weight"] = {"g1_v": fit.g1_v, "g2_v": fit.g2_v}
    for joint in (1, 2):
        found = arm.calibrate(joint)
        for name, fit in (("counter-clockwise", found.ccw), ("clockwise", found.cw)):
            print(
                f"joint {joint} {name:17s}  turns from {fit.starts_at_v:.2f} V, {fit.speed_per_volt:.0f} deg/s per volt "
                f"above {fit.dead_band_v:.2f} V, time constant {1000 * fit.time_constant_s:.0f} ms"
            )
            facts[f"joint {joint} {name}"] = {
                "starts_at_v": fit.starts_at_v, "dead_band_v": fit.dead_band_v, "speed_per_volt": fit.speed_per_volt,
                "time_constant_s": fit.time_constant_s, "worst_residual_deg": float(abs(fit.residuals_deg).max()),
            }  # fmt: skip
    print("The controller keeps these until it is switched off.")
    _hang(arm)
    return facts


def _arm_register(arm, options):
    from stereo_lab.arm.registering import register
    from stereo_lab.localization import Localizer
    from stereo_lab.recording import open_recording

    recording = open_recording(options.angles[0] if options.angles else None)
    localizer = Localizer.fit(recording)
    tell_fit(localizer, recording, arm=True)
    with _cameras(arm, recording, options) as cameras:
        arm.set_limits(recording.arm.limits_deg)
        _home_if_lost(arm)
        print("The arm moves: with the ball in its hand to a dozen places …", flush=True)
        found = register(arm, recording.arm, recording.arm_depth_mm, lambda: localizer.locate(*cameras.read()))
        _hang(arm)
    return _tell_registration(found, recording, options.keep)


def _cameras(arm, recording, options):
    """The cameras that see the arm: drawn ones for a virtual arm."""
    if hasattr(arm.port, "link_deg"):
        from stereo_lab.live import DrawnCameras

        print("A virtual arm: its pictures are drawn.")
        return contextlib.nullcontext(DrawnCameras(recording, arm.port))
    from stereo_lab.recording.cameras import CameraPair

    numbers = [usual if told is None else told for told, usual in ((options.left, 0), (options.right, 1))]
    return CameraPair(*numbers, recording.image_size)


def _tell_registration(found, recording, keep):
    from stereo_lab.kinematics.registration import NAMES, UNITS

    for name, unit, value, sigma in zip(NAMES, UNITS, found.values, found.sigmas, strict=True):
        print(f"{name:15s}{value:9.1f} {unit:3s}  ± {sigma:.1f}")
    apart = float((found.residuals_mm**2).sum(axis=1).mean() ** 0.5)
    print(f"{len(found.residuals_mm)} places; seen and calculated are {apart:.1f} mm apart (root mean square)")
    said = found.differences(recording.arm)
    print("\n".join(said) if said else "The links and the zeros are as they are told.")
    facts = {name: [float(v), float(s)] for name, v, s in zip(NAMES, found.values, found.sigmas, strict=True)}
    if keep:
        found.save(recording.registration_path)
        print(f"written: {recording.registration_path}")
    else:
        print("--keep writes it into the recording.")
    return {"values and sigmas": facts, "apart_mm": apart, "places": len(found.residuals_mm), "said": said}


def _arm_monitor(arm, options):
    if options.seconds is not None and not options.seconds > 0:
        raise StereoLabError(f"--seconds: expected a number above zero, got {options.seconds}.")
    print("Every line is a look at the arm; Ctrl-C ends it.")
    rows = []
    try:
        with contextlib.suppress(KeyboardInterrupt):  # the way to end it, so no fault: what was seen is kept
            _look_on(arm, options.seconds, rows)
    except ArmError:
        write_json_option(options.json, rows)  # what was seen before the arm was lost is kept too
        raise
    return rows


def _look_on(arm, seconds, rows):
    """Look at the arm five times a second and add what is seen to ``rows``; without an end where seconds is None."""
    start = time.monotonic()
    while seconds is None or time.monotonic() - start < seconds:
        status = arm.status()
        rows.append({"state": status.state, "angles_deg": list(status.position_deg), "time_ms": status.time_ms})
        print(f"{status.time_ms / 1000:8.1f} s  {status.state:5s} {_degrees(status.position_deg)}", flush=True)
        arm.wait(0.2)
        time.sleep(0.2 if hasattr(arm.port, "link_deg") else 0)  # a virtual arm's time is not ours


def _degrees(angles):
    return ", ".join(f"{angle:.2f}" for angle in angles) + " degrees"


ARM_ACTIONS = {
    "status": _arm_status, "home": _arm_home, "move": _arm_move, "calibrate": _arm_calibrate,
    "register": _arm_register, "monitor": _arm_monitor,
}  # fmt: skip
