"""Claims of report.html as patterns, each with the check that it must pass; explanations that claim nothing."""

from __future__ import annotations

from typing import Any

from tests.diagnose import report_evidence_checks as evidence
from tests.diagnose import report_other_checks as other
from tests.diagnose import report_verdict_checks as verdict
from tests.diagnose.report_told import LIKELY, STRENGTH

P = r"(above 0\.999|below 0\.001|[\d.]+|unknown)"
X = r"(-?[\d. ]*\d|-?beyond measure|unknown)"
E = r"(-?[\d.]+(?:e[+-]?\d+)?|beyond measure|unknown)"

CLAIMS: tuple[tuple[str, Any], ...] = (
    (r"Model and measurement agree: what is left between them is noise"
     r"(?:, after (\d+) numbers? of the model ha(?:s|ve) moved within tolerance)?\.", verdict.agreement),
    (rf"(?:The|Part of the) disagreement has (\d+) causes; the largest is (.+?) \((?:together )?probability {P}\)",
     verdict.many_causes),
    (r"(?:The|Part of the) disagreement is explained by (.+?\))(?=[;.])", verdict.few_causes),
    (r"; what is left is noise\.", verdict.only_noise_is_left),
    (r"No established effect accounts for what is left: (at most )?([\d.]+) % of the torque of (\S+?)"
     r"(?:; it changes with (.+?))?\.", verdict.left),
    (r"Something is left that no established effect accounts for\.", verdict.something_left),
    (r"Above: .+?\. Below, if it is .+?: what a model with .+? leaves unexplained after its numbers are fitted again,"
     r" in units of noise; shaded: two standard deviations\. Over the whole motion it adds up to (\d+) times the"
     r" noise\.",
     other.planned),
    (rf"Model and measurement disagree, and no effect is established as the cause"
     rf"(?:: the most probable, (.+?), has probability {P}, and 0\.95 is required)?\.", verdict.not_established),
    (r"There are no test data: the motion is too short to keep a part of it\. (?:Established on the data"
     r" of the fit: (.+?\)(?: and \d+ more)?)|No effect is established on the data of the fit)\.", verdict.untested),
    (r"The residual is largest (.+?)\.", verdict.appears),
    (r"((?:These estimates|This estimate) stopped before .+? converged: .+?\.)", verdict.unconverged),
    (r"The report claims only what has converged: (?:no effect is established|(.+?\)))\.",
     verdict.beyond_convergence),
    (r"This diagnosis was interrupted(?: while (.+?),)? before it was finished\.", verdict.interrupted),
    (r"Established by then: (.+?\)(?: and \d+ more)?)\.", verdict.by_then),
    (r"No effect had been established by then(?:; the most probable so far was (.+?))?\.",
     verdict.nothing_by_then),
    (r"The test data had not been opened\.", verdict.unopened),
    (rf"^(.+): (each )?({'|'.join(LIKELY)}) \((?:together )?probability {P}(?: or more)?\)\.$", verdict.finding),
    (rf"On the (test data|data of the fit), the gap goes from {X} to {X}; noise alone makes {X}\.", verdict.gap),
    (r"The gap (was not|could not be) measured\.", verdict.no_gap),
    (rf"At (\S+?)(, the joint with the greatest share before,)? the torque error goes from {E} to {E} (.+?), from"
     rf" {X} % to {X} % of its torque\.", verdict.worst),
    (rf"Posterior probability {P}( that one of these names is right)?: ({'|'.join(LIKELY)})"
     r"(, not established: 0\.95 is required)?\.", evidence.probability),
    (rf"The best structure with it against the best without it: log Bayes factor {X}"
     rf" \(({'|'.join(STRENGTH)}) evidence( against it)?\)\.", evidence.bayes),
    (rf"If it alone is left out, {X} % of the improvement on the test data is lost\.", evidence.lost),
    (rf"If it alone is left out, the improvement on the test data grows by {X} %\.", evidence.grown),
    (r"Every one of the (\d+) ranked structures holds (?:it|one of these names)\.", evidence.every_one),
    (r"None of the (\d+) ranked structures holds (?:it|one of these names)\.", evidence.none_of),
    (r"(\d+) of the (\d+) ranked structures hold (?:it|one of these names)\.", evidence.some_of),
    (rf"The best one without (?:it|them) has (.+?) instead; its log evidence is (lower|higher) by {X}, its probability"
     rf" {P}\.", evidence.without_it),
    (r"The data do not separate these effects:", evidence.rivals),
    (rf"^(.+?)(?: \((.+)\))?: probability {P}$", evidence.rival),
    (rf"Noise alone leaves {X} %\.", other.noise_leaves),
    (rf"dashed: noise alone, {X}", other.dashed),
    (r"They moved by no more than (\d) of their stated tolerances, so they are no findings\.", other.within_tolerance),
    (r"(\d+) numbers? moved by more than (\d) of the stated tolerances but is no finding: what is left"
     r" unexplained may have changed it\.", other.beyond_tolerance),
    (r"Nothing beyond what is said above\.", other.nothing_to_note),
    (r"Nothing: no finding waits for another measurement\.", other.nothing_to_measure),
    (r"More motion of (\S+)(?: \((.+?)\))?, slower, with the other joints at rest: a law that the catalogue lacks is"
     r" seen best where nothing else moves\.", other.more_motion),
    (r"The same motion again: a residual that depends only on the arm's state repeats\.", other.once_more),
    (r"A second recording of another motion, to test the answer on data that no decision has used\.",
     other.second_recording),
    (r"Run the diagnosis to its end: it needs no new measurement\.", other.to_its_end),
    (r"The diagnosis took (\d+) s\.", other.took),
    (r"^flexdyn (\S+), \S+ \S+: (.+)$", other.done),
)  # fmt: skip
CONSTANT = (
    r"^INTERRUPTED$",
    r"^The law depends on more than .+?: its line is an average\.$",
    r"^What would tell them apart:",
    r"Root mean square of simulated minus measured positions over windows of 0\.5 s.*?dashed line\.",
    r"Root mean squares on the test data\..*?corrected model\.",
    r"Positions are simulated without feedback over windows of 0\.5 s.*?hides its curves\.",
    r"The (?:pictures that explain most|equations in which most is left) come first\..*?are averages\.",
    r"before after: the corrected model",
    r"What the corrected model leaves beyond noise\..*?not sensor noise\.",
    r"Of the calibrated model, before the findings were added\..*?through the spring\.",
    r"The gap is here the sum of squares.*?share differently\.",
    r"Behind each name: its stated tolerance, one standard deviation\.",
    r"Those below 0\.1 are left out\..*?each by itself\.",
    r"A structure is a set of effects.*?that hold it\.",
    r"Fit: numbers are estimated and structures are compared.*?errors per joint\.",
    r"Beside this page: .*?report\.json, the same for programs\.",
    r"Why an effect was named, or was not: flexdyn diagnose \.\.\. --explain EFFECT@JOINT\.",
)
"""Explanations, which say the same on every page."""
