"""Client of photond, a global-illumination render service. The standard library is enough; numpy makes arrays of images,
matplotlib plots.

    import photond

    client = photond.Client()                                  # PHOTOND_URL, PHOTOND_TOKEN
    job = client.render("cornell-box", "photon_mapping", passes=16, layers=["caustic"])
    job.image(layer="caustic")                                 # ndarray, height x width x 3
    job.save("caustic.exr")

    print(client.methods["photon_mapping"])                    # its parameters, with units, ranges and defaults
    comparison = client.compare("cornell-box", ["path_tracing", "photon_mapping"], seconds=5,
                                reference="path_tracing:1024", seeds=[1, 2, 3])
    print(comparison)                                          # who reaches which error, and what it took
    comparison.plot()                                          # error over time, with bands over the seeds
"""

from ._version import __version__
from .bias import BiasMap
from .client import Client, Estimate
from .comparison import Comparison, ComparisonFailed
from .curves import Bound, Curve, Interval, MeanCurve
from .errors import (BadFile, BadRequest, Busy, Denied, Fault, Invalid, MissingPackage, NoSpace, NotFound, NothingYet,
                     PhotondError, ProtocolError, Refused, ServerFault, TimedOut, TooLarge, Unavailable, Unreachable,
                     WrongState)
from .job import Event, Job, JobCancelled, JobFailed
from .methods import Method, Methods, Parameter, UnknownName
from .pixels import FlipMap, Pixels
from .plots import plot_curves
from .requests import entry, look_at, reference
from .scene import Scene, UploadedImage
from .sequence import Sequence, SequenceFailed

__all__ = [
    "BadFile", "BadRequest", "BiasMap", "Bound", "Busy", "Client", "Comparison", "ComparisonFailed", "Curve", "Denied",
    "entry", "Estimate", "Event", "Fault", "FlipMap", "Interval", "Invalid", "Job", "JobCancelled", "JobFailed", "look_at",
    "MeanCurve", "Method", "Methods", "MissingPackage", "NoSpace", "NotFound", "NothingYet", "Parameter", "PhotondError",
    "Pixels", "plot_curves", "ProtocolError", "reference", "Refused", "Scene", "Sequence", "SequenceFailed", "ServerFault", "TimedOut",
    "TooLarge", "Unavailable", "UnknownName", "Unreachable", "UploadedImage", "__version__", "WrongState",
]
