"""The report of a diagnosis as an HTML file: verdict, budget, before and after, how far, where, which, what is left."""

from gap_diagnosis.report.document import diagnosis_report

__all__ = ["diagnosis_report"]
