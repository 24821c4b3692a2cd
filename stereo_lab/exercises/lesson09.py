"""Questions of lesson 09: a detector that learned."""

from __future__ import annotations

import numpy as np

from stereo_lab.common.shares import interval_95
from stereo_lab.exercises.answers import Choice, Function, Wrong
from stereo_lab.exercises.question import Question, lesson
from stereo_lab.recording import Recording

# Where and when a film is taken that tells nothing new, or all: another day alone, a room that it has seen, one that it has not
NEW = "(an? ?)?(other|different|new|unseen|unknown|unfamiliar|strange|foreign)"
DAY_ALONE = r"(on )?(the |a )?((next|another|other|new|different) (day|morning|week)|tomorrow|later|day later)"
SEEN_ROOM = (
    r"(?!.*\b(not|never)\b).*\b(((same|this|my|our|that|training) )+room|the room (where |in which )?(i|we|it)"
    r" ((was|were|have|has|had) )?(\w+ed|learnt|made|took|shot))\b.*"
)
ROOM_OF_USE = (
    "((frames|pictures|a film) )?((in|of|from) )*(the room )?(where |in which |that )?"
    "(i|we)(['’]ll| will| want to| am going to| are going to)? use it( in)?( later)?"
)
# Named places, though nobody knows where the film was taken
OTHER_PLACE = (
    "((frames|pictures|a (new )?film) )?((on|in|of|from|at) )*((the|my|our|a) )?"
    "(kitchen|garden|garage|cellar|(school )?gym|school|outside|outdoors|somewhere else|elsewhere|(living|bed|bath|class|dining) ?room"
    "|(friend|neighbou?r|grandma|grandpa|grandmother|grandfather|aunt|uncle|sister|brother)['’]?s (house|place|home|room|flat|kitchen)"
    f"|{NEW} (house|flat|building|school))"
)
NEW_DAY = f"(on )?(the |{NEW}) days?"
NEW_ROOM = (
    f"((twenty|new) )?((frames|pictures|films?|a film) )?((on|in|of|from) )*((the )?{NEW} (rooms?|places?)"
    "|an? (room|place) ((that )?(it|the detector) )?((has|had) )?(never|not) (yet )?(been )?(seen|saw)( before)?"
    "|an? (room|place) (that )?(it|the detector) (does|did) not know)"
)


def questions(recording: Recording) -> tuple[Question, ...]:
    """Eight questions, the same on any recording; see :mod:`stereo_lab.exercises`."""
    return lesson(
        "09", _line(), _probability(), _loss(), _gradient(), _one_or_none(), _judged_on(), _rule_of_three(), _fooled()
    )


def _line():
    tries = (
        (np.array([1.0, -2.0]), np.array([2.0, 0.5]), 3.0, 4.0, 5.0),
        (np.array([-1.0, 0.0, 2.5]), np.array([0.5, -3.0, 1.0]), 1.5, -1.0, 0.25),
    )
    return dict(
        asks="A thing has the evidence x and y. The line has the numbers a, b, c. What is the sum that is zero on the line?",
        answer=Function(
            line_sum, tries, 1e-6, "",
            (
                Wrong(lambda x, y, a, b, c: a * x + b * y, "every such line goes through x = 0, y = 0. c moves it away from there: it is added."),
                Wrong(lambda x, y, a, b, c: a * x + b * y + c > 0, "true or false says on which side. The next step needs how far as well: give the sum itself."),
                Wrong(lambda x, y, a, b, c: np.sign(a * x + b * y + c), "the sign says on which side. The next step needs how far as well: give the sum itself."),
                Wrong(lambda x, y, a, b, c: np.mean(a * x + b * y + c), "that is one number for all things. x and y hold a number for each thing, and each has its own sum: no mean."),
                Wrong(lambda x, y, a, b, c: np.sum(a * x + b * y + c), "that is one number for all things. x and y hold a number for each thing, and each has its own sum: no np.sum."),
                Wrong(lambda x, y, a, b, c: (a * x + b * y + c) / np.hypot(a, b), "that is the distance from the line. It is zero on it, too; asked for is the sum alone."),
                Wrong(lambda x, y, a, b, c: -(a * x + c) / b, "that is where the line lies above x. How far is the thing's own y from there? Weigh both, and add c."),
                Wrong(lambda x, y, a, b, c: x + y + c, "the weights are missing: a times x, b times y."),
                Wrong(lambda x, y, a, b, c: a * x + b * y + c == 0, "a thing lies on the line hardly ever. Give the sum itself."),
                Wrong(lambda x, y, a, b, c: a + b + c, "the evidence is missing: a times x, b times y."),
                Wrong(lambda x, y, a, b, c: a + x + b + y + c, "a and b weigh: they are multiplied with x and y."),
                Wrong(lambda x, y, a, b, c: a * y + b * x + c, "a belongs to x, and b to y."),
                Wrong(lambda x, y, a, b, c: a * x + b * y - c, "c is added: what is subtracted moves the line the other way."),
                Wrong(lambda x, y, a, b, c: a * x + b, "that is the line of y = a·x + b. Here y comes in itself, with a weight of its own."),
                Wrong(lambda x, y, a, b, c: (a * x + b * y) * c, "c is added to the rest, not multiplied."),
                Wrong(lambda x, y, a, b, c: y - a * x - b, "that works for one line, but cannot stand upright. Weigh both, and add c."),
            ),
            "above zero on one side, below on the other, and zero on the line.",
        ),
        hints=(
            "Each piece of evidence has its weight, as in lesson 02.",
            "Weigh x with a, y with b, add both, and c.",
            "return a * x + b * y + ____",
        ),
        code="def line_sum(x, y, a, b, c):\n    return a * x + b * y + c",
        reason="A line is where a weighted sum is zero. With more evidence it is a plane, and the sum only grows longer.",
        reference=line_sum,
    )  # fmt: skip


def _probability():
    tries = ((np.array([0.5, 1.0, -2.0]),), (np.array([4.0, -0.25]),))
    return dict(
        asks="The odds of a thing with the sum s are e^s to 1. What is its probability?",
        answer=Function(
            probability, tries, 1e-4, "",
            (
                Wrong(lambda s: np.exp(s), "those are the odds. Of odds 3 to 1 the probability is 3 / (3 + 1)."),
                Wrong(lambda s: 1 / (1 + np.exp(s)), "your probability falls as the sum grows. Look at the sign of s."),
                Wrong(lambda s: np.exp(s) / (1 - np.exp(s)), "odds of 3 to 1 are 3 of 4 in all: the 1 is added below the line."),
                Wrong(lambda s: 1 + np.exp(-s), "that is what stands below the line."),
                Wrong(lambda s: np.exp(-s), "that is one to the odds. How much is one part of all?"),
                Wrong(lambda s: s / (1 + s), "s is the logarithm of the odds. First the odds: np.exp(s)."),
                Wrong(lambda s: 1 / (1 + 10.0 ** (-s)), "e, not 10: np.exp."),
                Wrong(lambda s: 1 / (1 + 2.0 ** (-s)), "e, not 2: np.exp."),
                Wrong(lambda s: np.exp(s) / np.exp(s).sum(), "here each thing stands by itself: its odds against no ball, 1. The sum over all things comes later."),
                Wrong(lambda s: np.exp(s) / (1 + np.exp(s).sum()), "here each thing stands by itself. The sum over all things comes later, in \"one is the ball, or none\"."),
                Wrong(lambda s: np.exp(s) / 1 + np.exp(s), "brackets: the 1 and the odds stand below the line together."),
                Wrong(lambda s: np.exp(s) / (np.exp(s) - 1), "odds of 3 to 1 are 3 of 4 in all: the 1 is added below the line."),
                Wrong(lambda s: 1 - np.exp(-s), "with s below zero that is no probability. Odds of 3 to 1 are 3 of 4."),
                Wrong(lambda s: np.exp(s) / 2, "halved it is a probability only where the odds are 1. Odds of 3 to 1 are 3 of 4."),
                Wrong(lambda s: np.exp(s) / 100, "odds are no percentages. Odds of 3 to 1 are 3 of 4."),
                Wrong(lambda s: np.tanh(s), "that goes from −1 to 1. A probability begins at 0."),
                Wrong(lambda s: np.clip(s, 0, 1), "s is the logarithm of the odds, and no probability that was cut off. First the odds: np.exp(s)."),
                Wrong(lambda s: s > 0, "that says on which side, 0 or 1. A probability lies in between, and the next step needs it whole."),
                Wrong(lambda s: np.log(np.abs(s)), "that is the other way. s is a logarithm already: np.exp takes it back."),
            ),
            "0.5 at zero, nearly 1 far above, nearly 0 far below.",
        ),
        hints=(
            "Odds of 3 to 1: three of four.",
            "Odds of e^s to 1: e^s of e^s + 1. Divide both by e^s.",
            "return 1 / (1 + np.exp(____))",
        ),
        code="def probability(s):\n    return 1 / (1 + np.exp(-s))",
        reason="It is called the logistic function, and gives the logistic regression its name.",
        reference=probability,
    )  # fmt: skip


def _loss():
    tries = (
        (np.array([0.9, 0.2]), np.array([1.0, 0.0])),
        (np.array([0.5, 0.25]), np.array([1.0, 0.0])),
        (np.array([0.1, 0.7, 0.6]), np.array([1.0, 0.0, 1.0])),
        (np.full(2000, 0.5), np.arange(2000) % 2.0),  # so many, as the next steps have, that a product underflows to 0
    )
    return dict(
        asks="p are probabilities told, y is 1 for a ball and 0 for anything else. What is the mean loss, −log of the probability given to what is true?",
        answer=Function(
            loss, tries, 1e-4, "",
            (
                Wrong(lambda p, y: -np.mean(np.log(p)), "that blames things that are no ball as well for a small p. What was given to the truth there is 1 − p."),
                Wrong(lambda p, y: np.mean(y * np.log(p) + (1 - y) * np.log(1 - p)), "a logarithm of a probability is below zero. A loss counts upward: put a minus before it."),
                Wrong(lambda p, y: -np.sum(y * np.log(p) + (1 - y) * np.log(1 - p)), "that is the sum. With more things it grows by itself; take the mean."),
                Wrong(lambda p, y: -np.mean(y * np.log(p)), "things that are no ball are missing: whoever calls everything a ball would have no loss."),
                Wrong(lambda p, y: np.mean((p - y) ** 2), "squares are a loss, too, but not this one. It hardly minds a ball that was given 0.001."),
                Wrong(lambda p, y: np.mean(np.abs(p - y)), "that is the mean gap. The logarithm is harder on whoever was sure and wrong."),
                Wrong(lambda p, y: -np.mean((1 - y) * np.log(p) + y * np.log(1 - p)), "the other way round: a ball (y = 1) must be blamed for a small p, and anything else for a large one."),
                Wrong(lambda p, y: -np.mean(y * np.log10(p) + (1 - y) * np.log10(1 - p)), "np.log10 counts in tens. Here it is np.log, in powers of e, as the odds are."),
                Wrong(lambda p, y: -np.mean(y * np.log2(p) + (1 - y) * np.log2(1 - p)), "np.log2 counts in twos. Here it is np.log, in powers of e, as the odds are."),
                Wrong(lambda p, y: -np.log(np.mean(np.where(y == 1, p, 1 - p))), "first the logarithm of each, then the mean: who is sure and wrong once must not hide among the others."),
                Wrong(lambda p, y: np.mean(np.where(y == 1, p, 1 - p)), "that is the mean of what was given to the truth. Its −log, one by one, and then the mean."),
                Wrong(lambda p, y: np.prod(np.where(y == 1, p, 1 - p)), "that is how probable the whole truth was. A mean of −log is asked for."),
                Wrong(lambda p, y: -np.log(np.where(y == 1, p, 1 - p)), "that is the loss of each thing. One number for all is asked for: their mean."),
                Wrong(lambda p, y: -np.median(np.log(np.where(y == 1, p, 1 - p))), "the median does not feel who is sure and wrong. Take the mean."),
                Wrong(lambda p, y: np.mean((p > 0.5) != y), "that is the share of mistakes. It does not ask how sure somebody was."),
                Wrong(lambda p, y: np.mean((p > 0.5) == y), "that is the share of right answers. It does not ask how sure somebody was."),
                Wrong(lambda p, y: np.mean(p - y), "gaps upward and downward cancel. And the logarithm is missing."),
                Wrong(lambda p, y: -np.mean(np.log(p[y == 1])), "that is the loss of the balls alone: whoever calls everything a ball would have none."),
                Wrong(lambda p, y: -(np.mean(np.log(p[y == 1])) + np.mean(np.log(1 - p[y == 0]))), "those are two means, one for balls and one for others. Each thing counts once: one mean of all."),
                Wrong(lambda p, y: -(np.mean(np.log(p[y == 1])) + np.mean(np.log(1 - p[y == 0]))) / 2, "so a ball counts more, the fewer there are. Each thing counts once: one mean of all."),
                Wrong(lambda p, y: -np.mean(y * np.log(p) + 1 - y * np.log(1 - p)), "brackets: (1 - y) * np.log(1 - p)."),
                Wrong(lambda p, y: -np.mean(p * np.log(p) + (1 - p) * np.log(1 - p)), "that is how unsure p is. The truth, y, does not come into it."),
            ),
            held=("p", "y"),
            of_all=_of_a_product,
            endless="somewhere the logarithm of 0 is taken. What was given to the truth is p for a ball, 1 − p for anything else.",
            praise="who is sure and right loses next to nothing; who is sure and wrong loses most.",
        ),
        hints=(
            "What probability was given to the truth of a ball? And of something else?",
            "p where y is 1, 1 − p where y is 0. np.where(y == 1, …, …) chooses.",
            "return -np.mean(np.log(np.where(y == 1, p, ____)))",
        ),
        code="def loss(p, y):\n    return -np.mean(np.log(np.where(y == 1, p, 1 - p)))",
        reason="The product of all these probabilities is how probable the whole truth was; its logarithm is a sum.",
        reference=loss,
    )  # fmt: skip


def _of_a_product(outputs):
    """What to say of a loss that has no bounds where things are many, and there alone; "" of all others."""
    numbers = all(isinstance(output, float) for output in outputs)
    if numbers and np.isinf(outputs[-1]) and np.isfinite(outputs[:-1]).all():
        return "a product of 2000 probabilities is so small that it is 0 for the computer, and 0 has no logarithm. Take the logarithm of each first, and then their mean."
    return ""


def _gradient():
    tries = (
        (np.array([[1.0, 2.0], [1.0, -1.0], [1.0, 0.5]]), np.array([0.9, 0.4, 0.3]), np.array([1.0, 0.0, 1.0])),
        (np.array([[1.0, 0.0, 3.0], [1.0, 2.0, 1.0]]), np.array([0.2, 0.7]), np.array([1.0, 0.0])),
    )
    return dict(
        asks="x has a row for each thing. How does the loss change with each weight? The mean over all things of (p − y) times the thing's row.",
        answer=Function(
            gradient, tries, 1e-6, "",
            (
                Wrong(lambda x, p, y: x.T @ (y - p) / len(y), "the other way round: where p is too large, the loss grows with the weight. p − y."),
                Wrong(lambda x, p, y: x.T @ (p - y), "that is the sum. Take the mean: divide by how many things there are."),
                Wrong(lambda x, p, y: np.mean(p - y), "one number for all weights. Each weight has its own evidence: multiply with the rows of x."),
                Wrong(lambda x, p, y: x.T @ p / len(y), "y is missing: what counts is how far p is from the truth."),
                Wrong(lambda x, p, y: x.T @ (p - y) / x.shape[1], "divided by the number of weights. Divide by the number of things, len(y)."),
                Wrong(lambda x, p, y: x.T @ (p - y) / 2, "divided by 2, whatever comes in: that is a mean of two things alone. Divide by the number of things, len(y)."),
                Wrong(lambda x, p, y: (), "nothing comes out. If np.gradient stands there: it takes differences of neighbours in a list, and one loss has none. Write the mean itself."),
                Wrong(lambda x, p, y: x.T @ (p - y) ** 2 / len(y), "no square: the sign says which way to go."),
                Wrong(lambda x, p, y: x.T @ np.abs(p - y) / len(y), "the sign says which way to go: leave it."),
                Wrong(lambda x, p, y: x.T @ ((p - y) * p * (1 - p)) / len(y), "that is the gradient of a mean of squares. With our loss p·(1 − p) cancels: the plain difference p − y is left."),
                Wrong(lambda x, p, y: x.T @ (p - y) / x.size, "divided by all numbers of the table. Divide by the number of things, len(y)."),
                Wrong(lambda x, p, y: x.T @ y / len(y), "p is missing: what counts is how far p is from the truth."),
                Wrong(lambda x, p, y: x[y == 1].T @ (p - y)[y == 1] / len(y), "things that are no ball teach as well: take all rows."),
                Wrong(lambda x, p, y: x.T @ np.sign(p - y) / len(y), "how far p is off counts, not the sign alone."),
                Wrong(lambda x, p, y: np.median(x * (p - y)[:, None], axis=0), "the median does not add up. Take the mean."),
                Wrong(lambda x, p, y: p - y, "that is one number for each thing. Each weight has its own: multiply with the rows of x, then take the mean."),
                Wrong(lambda x, p, y: x * (p - y)[:, None], "that is a row for each thing. Take the mean over the things: axis=0."),
                Wrong(lambda x, p, y: np.mean(x * (p - y)[:, None], axis=1), "that is a mean for each thing. One for each weight is asked for: take the mean over the things, along the other axis."),
                Wrong(lambda x, p, y: np.mean(x * (p - y)[:, None]), "one number for all weights. Each weight has its own: a mean of each column, axis=0."),
                Wrong(lambda x, p, y: x[:, 1:].T @ (p - y) / len(y), "the column of ones has a weight, too: c. Take all columns."),
                Wrong(lambda x, p, y: x.mean(0) * np.mean(p - y), "first multiply each row with its own p − y, then take the mean."),
            ),
            "as many numbers as weights: which way the loss rises. We go the other way.",
            endless="is something divided by the evidence? Multiply with it.",
        ),
        hints=(
            "One number for each column of x.",
            "x.T has a row for each weight. x.T @ (…) adds up the products.",
            "return x.T @ (p - ____) / len(y)",
        ),
        code="def gradient(x, p, y):\n    return x.T @ (p - y) / len(y)",
        reason="The logarithm of the loss and the e of the probability cancel: what is left is the plain difference p − y.",
        reference=gradient,
    )  # fmt: skip


def _one_or_none():
    tries = ((np.array([1.0, -1.0, 2.0]),), (np.array([-3.0, -2.5]),), (np.array([0.5]),))
    return dict(
        asks="One thing in the picture is the ball, or none is. s are the sums of all its things. How probable is each of them?",
        answer=Function(
            one_or_none, tries, 1e-4, "",
            (
                Wrong(lambda s: np.exp(s) / np.exp(s).sum(), "they add up to 1, so in every picture something is the ball. Where is \"none\"? Its odds are 1."),
                Wrong(lambda s: 1 / (1 + np.exp(-s)), "each thing by itself: two of them could be the ball with 0.9 each. They share with each other."),
                Wrong(lambda s: np.exp(s), "those are the odds. Divide by all of them together, \"none\" among them."),
                Wrong(lambda s: np.exp(s) / (len(s) + np.exp(s).sum()), "\"none\" is one choice, however many things there are: 1, not a 1 for each."),
                Wrong(lambda s: s / (1 + s.sum()), "s are logarithms. First the odds: np.exp(s)."),
                Wrong(lambda s: np.exp(s.max()) / (1 + np.exp(s).sum()), "that is the best one. A probability for each thing is asked for."),
                Wrong(lambda s: 1 / (1 + np.exp(s).sum()), "that is \"none\". And the things?"),
                Wrong(lambda s: np.append(np.exp(s), 1) / (1 + np.exp(s).sum()), "one number too many: \"none\" is counted below the line, and only the things are asked for."),
                Wrong(lambda s: np.append(1, np.exp(s)) / (1 + np.exp(s).sum()), "one number too many: \"none\" is counted below the line, and only the things are asked for."),
                Wrong(lambda s: 1 - np.exp(s) / (1 + np.exp(s).sum()), "that is how probable it is that it is not this one."),
                Wrong(lambda s: np.exp(s).sum() / (1 + np.exp(s).sum()), "that is how probable it is that there is a ball at all. A probability for each thing is asked for."),
                Wrong(lambda s: np.exp(s) / (1 + np.exp(s.sum())), "the odds are added up, not the sums: np.exp(s).sum(), not np.exp(s.sum())."),
                Wrong(lambda s: np.exp(s) / (1 + np.exp(s).mean()), "they share the whole, not the mean: a sum stands below the line."),
                Wrong(lambda s: np.exp(s) / 1 + np.exp(s).sum(), "brackets: the 1 and the sum stand below the line together."),
                Wrong(lambda s: np.exp(s) / (np.exp(s).sum() - 1), "\"none\" takes a share as well: its 1 is added."),
                Wrong(lambda s: np.exp(s) / (1 + np.exp(s).sum() - np.exp(s)), "those are the odds against all others. A share is a part of all together, its own odds among them."),
                Wrong(lambda s: np.exp(s - s.max()) / (1 + np.exp(s - s.max()).sum()), "s.max() is taken off the things, and not off \"none\": its odds are no longer 1 then, but np.exp(-s.max())."),
                Wrong(lambda s: probability(s) / (1 + probability(s).sum()), "the 1 of \"none\" is its odds, and here probabilities are added to it. Share the odds of the things, np.exp(s)."),
                Wrong(lambda s: (1 / (1 + np.exp(-s))) / (1 / (1 + np.exp(-s))).sum(), "they add up to 1, so in every picture something is the ball. Share the odds, np.exp(s), and count the 1 of \"none\"."),
                Wrong(lambda s: np.sort(np.exp(s) / (1 + np.exp(s).sum())), "the right shares, in another order: leave them where the things stand."),
                Wrong(lambda s: np.argmax(s), "that is the number of the best one. A probability for each thing is asked for."),
                Wrong(lambda s: (s == s.max()) * 1.0, "that leaves all to the best one. How sure can one be? Share it by the odds."),
                Wrong(lambda s: np.exp(s) / (np.e + np.exp(s).sum()), "the odds of \"none\" are 1, not e."),
                Wrong(lambda s: np.exp(-s) / (1 + np.exp(-s).sum()), "your probability falls as the sum grows. Look at the sign of s."),
            ),
            "all of them and \"none\" add up to 1.",
        ),
        hints=(
            "Lesson 02 had this formula. Who shares the 1?",
            "Odds: np.exp(s), and 1 for none. Each probability is its odds, divided by all odds together.",
            "return np.exp(s) / (____ + np.exp(s).sum())",
        ),
        code="def one_or_none(s):\n    return np.exp(s) / (1 + np.exp(s).sum())",
        reason="Whoever gains takes it from all others, and from none: two balls in one picture cannot both be the ball.",
        reference=one_or_none,
    )  # fmt: skip


def _judged_on():
    return dict(
        asks="You filmed for one minute and marked twenty frames. On which frames do you judge what was learned, so that you believe the score in another room?",
        answer=Choice(
            "another day in another room",
            (
                Wrong("the same twenty", "it knows those by heart. The score says how well it remembers."),
                Wrong("the frames just after them", "a tenth of a second later the same things stand at the same places. Only the noise is new."),
                Wrong("every second frame of the film", "each of them has a twin in the training, a tenth of a second before it."),
                Wrong("the last ten seconds of the film", "better: it has not seen them. But the room, the lamp and the shirt are the same, and it may have learned those."),
            ),
            "what is to be new there must be new in the test.",
            same=(
                ("(neither|none) of (them|these)[,;:]?", ""),
                (f"^{ROOM_OF_USE}$", "another day in another room"),
                (f"((film|frames|pictures) )?((on|in|of|from) )*{NEW} (day,? and (an? )?room|room,? and (an? )?day)", "another day in another room"),
                (f"^({DAY_ALONE},? (and )?)?{OTHER_PLACE}(,? (and )?{DAY_ALONE})?$", "another day in another room"),
                (f"(on )?(frames|pictures) ((that )?it (has|had) )?(never|not) (yet )?seen,? (in|from|of) {NEW} (room|place)", "another day in another room"),
                (f"{NEW_ROOM}(,? (and )?{NEW_DAY})?|{NEW_DAY},? (and |but )?{NEW_ROOM}", "another day in another room"),
                ("^(on )?(the )?((same|marked|training) )*(twenty|20|frames)( (same|marked|training))?( frames)?$", "the same twenty"), ("(the )?(frames )?just after( them)?", "the frames just after them"),
                ("(the )?last ((ten|10) )?seconds( of (the|my) (film|minute))?", "the last ten seconds of the film"), ("every (second|2nd|other) (frame|one)( of (the|my) film)?", "every second frame of the film"),
            ),
            not_meant=(
                (r"(?=.*\brooms?\b)(?!.*\b(not|never|than)\b).*\b(of|in|from) (the|this|that|my) ((same|whole|training) )?film\b.*", "the film was taken in one room, and it knows that one. Where do you film again?"),
                (rf"(?=.*\b(day|film|time|morning|week)\b){SEEN_ROOM}", "better than the same film: the light may be another one. But the room stays, and you want to believe the score in another room."),
                (f"{SEEN_ROOM}|(in )?((the|a) )?room", "the room stays, and you want to believe the score in another one."),
                (DAY_ALONE, "a day alone changes the light. What changes the things round the ball?"),
            ),
            beside=(
                (r".*(new|other|different|another|except|all but|rest|remaining).*(frames|film|twenty).*", "new frames, yes. But of which room, and of which day? The rest of the film shows what the twenty show."),
                (r"all|all of them|every(thing)?|(the )?((whole|same) )?film|all frames( of the film)?|every frame", "the film has the twenty in it, and its other frames show the same room. What is to be new?"),
                (rf"((with|by|on) )?{NEW} (camera|phone|ball|lamp|light|lighting)s?", "one thing is new then, and the room stays with all that is in it. Where do you film instead?"),
                (r".*\b(held|hold|kept|left)[ -]?out\b.*|.*\b(validation|test|random)\b.*|.*\d ?(%|percent).*|(the )?(first|last|middle) .*|.*\b((not|never) (yet )?|un)seen\b.*", "of which film? Frames of the same one, though it never saw them, show the room, the lamp and the shirt that it knows."),
                (r"clutter_?test|clutter", "that is a room of the renderer's, with its own ball. For your ball you film again: where, and when?"),
            ),
        ),
        hints=(
            "What will be different when you use it?",
            "In another room all is new: things, light, where the ball lies. In which of the choices is all of that new?",
            'judged_on = "another day in another ____"',
        ),
        code='judged_on = "another day in another room"',
        reason="A test answers only the question that it asks: the same room again, or another one.",
        reference="another day in another room",
    )  # fmt: skip


def _rule_of_three():
    tries = ((30,), (100,), (400,), (1000,))  # not 300: there 1 %, a share of 1, is right by chance
    laws = (
        lambda n: 100 * (1 - 0.05 ** (1 / n)),
        lambda n: 100 * (1 - np.exp(-3 / n)),
        lambda n: -100 * np.log(0.05) / n,
        lambda n: 100 * (1 - 0.025 ** (1 / n)),
        lambda n: 100 * (1 - 0.05 ** (1 / (n + 1))),
        lambda n: 100 * interval_95(0, n)[1],
    )
    is_a_share = "that is the share. In percent it is a hundred times as much."
    return dict(
        asks="None of n empty pictures was answered. Up to what percentage may the true share q of false alarms still be, so that none of n shows 5 times of 100?",
        answer=Function(
            at_most_percent, tries, 1e-3, "%",
            (
                *(Wrong(lambda n, law=law: law(n) / 100, is_a_share) for law in laws),
                Wrong(lambda n: 100 * (1 - 0.95 ** (1 / n)), "so rare that none shows 95 times of 100. How frequent may it be so that none shows 5 times of 100?"),
                *(Wrong(lambda n, of=of: of * (1 - 0.05**1 / n), "that is 1 − 0.05 / n: 5 % divided by n. Its n-th root is asked for, 0.05 ** (1 / n), with brackets, for ** comes before /.") for of in (1, 100)),
                Wrong(lambda n: 100 * 0.05 ** (1 / n), "that is 1 − q, the share of pictures that are rightly left empty. q is asked for."),
                Wrong(lambda n: 0.05 ** (1 / n), "that is 1 − q, the share of pictures that are rightly left empty. q is asked for."),
                Wrong(lambda n: 100 * 0.95**n, "that is how often none of n shows when each shows with 5 %. Asked for is q, not how often."),
                Wrong(lambda n: 0.95**n, "that is how often none of n shows when each shows with 5 %. Asked for is q, not how often."),
                Wrong(lambda n: 100 * (1 - 0.95**n), "that is how often at least one of n shows when each shows with 5 %. Asked for is q, not how often."),
                Wrong(lambda n: 1 - 0.95**n, "that is how often at least one of n shows when each shows with 5 %. Asked for is q, not how often."),
                Wrong(lambda n: 100 * (1 - 0.05**n), "that is 100 %, and not one of yours was answered. (1 − q) to the power n is 0.05: take the n-th root of 0.05, not its n-th power."),
                Wrong(lambda n: 100 / (n + 1), "one of n + 1 is what the next picture may be expected to do. What may still be true is more: none of n shows 5 times of 100 with three of n."),
                Wrong(lambda n: 100 / (n + 2), "one of n + 2 is what the next picture may be expected to do. What may still be true is more: none of n shows 5 times of 100 with three of n."),
                Wrong(lambda n: 100 / np.sqrt(n), "the root belongs to shares near a half. None of n goes with 3 / n."),
                Wrong(lambda n: 100 * (1 - 0.5 ** (1 / n)), "so frequent that none shows every second time. Every twentieth time is asked for: 5 %."),
                Wrong(lambda n: 100 * (1 - 0.01 ** (1 / n)), "so frequent that none shows once in a hundred times. Every twentieth time is asked for: 5 %."),
                Wrong(lambda n: 100 * 3, "divide by n: ten times as many pictures, a tenth of it."),
                Wrong(lambda n: 95.0, "95 % is how sure you are. Of what? Of three in n at most."),
                Wrong(lambda n: 5.0, "5 % is how often you may be wrong. About what? About three in n at most."),
                Wrong(lambda n: 10.0, "right for 30 pictures. With more of them it is less: use n."),
                Wrong(lambda n: 0.0 * n, "none of 30 is not none at all. Throw a die four times: no six does not mean that it has none."),
                Wrong(lambda n: 3 / n, is_a_share),
                Wrong(lambda n: 100 / n, "that is one of n. One of n would often not show among n pictures: take three."),
                Wrong(lambda n: n / 3, "upside down: more pictures say it more exactly."),
                Wrong(lambda n: 3.0, "it depends on n: ten times as many pictures, a tenth of it."),
                Wrong(lambda n: 5 / n, "the 5 of the 100 − 95 is in the 3 already: 0.05 is e to the power of −3."),
                Wrong(lambda n: 100 - 300 / n, "that is how many rightly got none, at least. How many false alarms, at most?"),
            ),
            "10 % for 30 pictures; brackets that leave 2.5 % on each side say 11. For one in a thousand you need three thousand.",
            also=laws,
        ),
        hints=(
            "(1 − q) to the power n is 0.05. The left side is about e to the power −n·q, and 0.05 is about e to the power −3.",
            "So n·q is about 3: three of n pictures, as a share 3 / n. In percent?",
            "return 100 * ____ / n",
        ),
        code="def at_most_percent(n):\n    return 100 * 3 / n",
        reason="With a true share q none of n shows with the probability (1 − q)^n, about e^(−n q). That is 5 % for n q = 3.",
        reference=at_most_percent,
    )  # fmt: skip


def _fooled():
    return dict(
        asks="The lamp is exchanged for light from all sides: the ball looks as flat as a printed disc. Which piece of evidence speaks against it now?",
        answer=Choice(
            "shade",
            (
                Wrong("contrast", "it is as red as before, and what is round it is not. Which piece looks at light and dark on the ball itself?"),
                Wrong("rim", "its edge is where it was. Which piece looks at the inside?"),
                Wrong("lobes", "its outline is as round as before."),
                Wrong("unique", "it is still the only red thing, or not: the lamp changes nothing there."),
                Wrong("overflow", "the colour ends at the rim as before."),
            ),
            "a ball is lighter on one side, and in even light it is not. The piece \"dark\" goes with it.",
            same=(
                ("(the )?shad(e|ow|ows|ing|ed side)|schade", "shade"), ("(the )?(light|lighter|bright|brighter|dark|darker)( and dark)? side", "shade"),
                ("((the ball|it) is )?(lighter|brighter|darker) on one side|one side (is )?(lighter|brighter|darker)( than the other( side)?)?", "shade"),
                ("(the )?shade,? ?(and |\\(and )?(the )?dark\\)?|(the )?dark,? ?(and )?(the )?shade|dark", "shade"), ("(the )?outline|(the )?shape", "lobes"), ("(the )?edge", "rim"),
            ),
            not_meant=(
                ("(the )?(colou?r.? shade|shade of (the )?(colou?r|red)).*", "it is as red as before. Which piece of evidence looks at light and dark on the ball?"),
                ("(the )?(ball's |cast )?shadows? (of the ball|(on|under|behind) the (?!ball).*)", "what lies beside the ball is no part of it. Which piece of evidence looks at light and dark on the ball?"),
            ),
            beside=(
                ("((the )?(contrast|difference) )?((between|of|in) )?(the )?(light|bright) and (the )?dark.*", "light and dark on the ball, yes. Which piece of evidence looks at that? Contrast asks how red it is, beside what is round it."),
                ("(the )?(light|lighting|lamp|brightness|lightness|sun|highlights?|bright spot)", "that is what changes. Which piece of evidence looks at light and dark on the ball?"),
                ("(the )?(colou?r|redness|red)", "it is as red as before. Which piece of evidence looks at light and dark on the ball?"),
                ("ends|astray|within|beyond|unsure|(longest )?arc", "its edge and its outline are as before. Which piece of evidence looks at light and dark on the ball?"),
                ("none|nothing", "it looks as flat as a printed disc, and in the pictures it learned from balls never did. Which piece saw that?"),
                ("all( of them)?|everything", "most stay: edge, outline and colour are as before. Which one piece is gone?"),
            ),
        ),
        hints=(
            "What changes when light comes from all sides? Look at the pieces of evidence of lesson 02.",
            "The ball was lighter on the side of the lamp. Which piece measures that?",
            'gone = "sh____"',
        ),
        code='gone = "shade"',
        reason="What was never different in the training cannot be known to change: all balls there had a lamp on one side.",
        reference="shade",
    )  # fmt: skip


def line_sum(x: float, y: float, a: float, b: float, c: float) -> float:
    """The weighted sum that is zero on a line."""
    return a * x + b * y + c


def probability(s: float) -> float:
    """The probability of odds e^s to 1."""
    return 1 / (1 + np.exp(-s))


def loss(p: np.ndarray, y: np.ndarray) -> float:
    """The mean of −log of the probability that was given to what is true."""
    return float(-np.mean(np.log(np.where(y == 1, p, 1 - p))))


def gradient(x: np.ndarray, p: np.ndarray, y: np.ndarray) -> np.ndarray:
    """How the mean loss changes with each weight."""
    return x.T @ (p - y) / len(y)


def one_or_none(s: np.ndarray) -> np.ndarray:
    """The probability of each thing, where one of them is the ball or none is."""
    return np.exp(s) / (1 + np.exp(s).sum())


def at_most_percent(n: int) -> float:
    """The highest share, in percent, of what was not seen in n tries (95 %)."""
    return 100 * 3 / n
