"""The paper's study, reproduced: equations checked, figures drawn, statements measured."""

from flexdyn.paper.chapter import Check
from flexdyn.paper.study import PaperStudy, run_paper_study

__all__ = ["Check", "PaperStudy", "run_paper_study"]
