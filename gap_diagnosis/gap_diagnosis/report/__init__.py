"""The report of a diagnosis as one HTML file: verdict, how far, where, which, before and after, what is left."""

from gap_diagnosis.report.document import diagnosis_report

__all__ = ["diagnosis_report"]
