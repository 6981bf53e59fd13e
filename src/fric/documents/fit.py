"""How well a friction model fits, as it stands in a friction file."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal

from pydantic import Field, model_validator

from fric.documents.generated import FilePart
from fric.documents.plant import PlantPart
from fric.documents.quantity import CovarianceBlock, Part, Quantity
from fric.records.preparation import Preparation


class PreparedPart(FilePart[Preparation]):
    """What was made of a record before a model was replayed along it."""

    own: list[str] = Field(default_factory=list, description="what the record adds of its own, fitted beside the model")


class FitRecord(Part):
    """One record that a model was fitted to."""

    record: str
    kind: str | None = None
    rmse: Quantity | None = Field(None, description="measured less replayed force")
    energy: Quantity | None = Field(None, description="energy lost per cycle")
    rmse_held_out: Quantity | None = Field(None, description="the same over the cycles that the fit did not see")
    inertia_share: float | None = Field(None, description="size of the inertia relative to the logged force")
    damping_share: float | None = Field(None, description="size of the drive's damping relative to the logged force")
    prepared: PreparedPart | None = None
    offset: Quantity | None = Field(None, description="constant force of this record alone")
    damping: Quantity | None = Field(None, description="force over velocity that was fitted beside the friction")
    mass: Quantity | None = Field(None, description="mass that was fitted beside the friction")


class Fit(Part):
    """How well a model fits, what it was fitted to, and what was done to the records before."""

    method: str = ""
    plant: PlantPart | None = Field(None, description="the plant whose part was taken off the logged force")
    taken_off: list[Literal["damping", "inertia"]] | None = Field(
        None, description="what of the plant was taken off the logged force; empty where nothing was"
    )
    rmse: Quantity | None = None
    r2: float | None = Field(None, description="share of the force's variance that is explained")
    points: int | None = Field(None, description="strokes")
    samples: int | None = None
    between_strokes: Quantity | None = Field(None, description="scatter of strokes beyond their own noise")
    between_records: dict[Literal["level", "offset"], Quantity] | None = Field(
        None, description="standard deviation of the level and the offset from record to record"
    )
    left_out: int | None = Field(None, description="strokes that stand off all others")
    negative: Fit | None = Field(None, description="the same of the negative direction's own map")
    alpha_sum: Quantity | None = Field(None, description="sum of alpha before it was normalised")
    virgin_curve_rmse: Quantity | None = None
    blocks: str | None = Field(None, description="why there are as many slip blocks as there are")
    records: list[FitRecord] | None = None
    covariance: CovarianceBlock | None = Field(None, description="how the parameters err together")

    @model_validator(mode="before")
    @classmethod
    def _of_an_older_file(cls, given: Any) -> Any:
        """Turn the words by which files before `taken_off` told of it into data."""
        if not isinstance(given, Mapping) or "taken_off" in given:
            return given
        records = given.get("records")
        ready = [one.get("prepared", one) for one in records or () if isinstance(one, Mapping)]
        if any(isinstance(one, Mapping) and "inertia_share" in one for one in ready):
            return {**given, "taken_off": ["inertia", "damping"]}
        if "drive damping taken off" in str(given.get("method", "")):
            return {**given, "taken_off": ["damping"]}
        return given
