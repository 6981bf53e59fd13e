from .drive.sensing import Encoder as Encoder
from .errors import FricError as FricError
from .estimate import estimate_rows as estimate_rows
from .figures.static_map import draw_static_map as draw_static_map
from .figures.style import save_figure as save_figure
from .identify.static import identify_static as identify_static
from .io.documents import document_schema as document_schema
from .io.documents import document_types as document_types
from .io.documents.mapping import MappingDocument as MappingDocument
from .io.friction import static_tree as static_tree
from .io.hdf5 import read_logs as read_logs
from .io.hdf5 import read_records as read_records
from .io.hdf5 import write_logs as write_logs
from .io.ingest import Ingested as Ingested
from .io.ingest import ingest as ingest
from .io.ingest import sizes as sizes
from .io.machine import read_machine as read_machine
from .io.output import refuse_existing as refuse_existing
from .io.plant import read_plant as read_plant
from .io.provenance import provenance as provenance
from .io.yaml import dump as dump
from .io.yaml import read_document as read_document
from .io.yaml import write_document as write_document
from .log import FrequencyResponse as FrequencyResponse
from .log import Log as Log
from .simulate.experiment import experiment as experiment

__version__: str
