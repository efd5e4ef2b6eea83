"""DICOM files for the tests, written with pydicom: classic slices, enhanced files, mosaics of Siemens, segmentations."""
import os
import struct

import numpy as np
from pydicom.dataset import Dataset, FileDataset, FileMetaDataset
from pydicom.sequence import Sequence
from pydicom.uid import ExplicitVRLittleEndian, ImplicitVRLittleEndian, generate_uid

CT, MR = "1.2.840.10008.5.1.4.1.1.2", "1.2.840.10008.5.1.4.1.1.4"
ENHANCED_CT, ENHANCED_MR = "1.2.840.10008.5.1.4.1.1.2.1", "1.2.840.10008.5.1.4.1.1.4.1"
LEGACY_CT, ENHANCED_PET = "1.2.840.10008.5.1.4.1.1.2.2", "1.2.840.10008.5.1.4.1.1.130"
CAPTURE, SEGMENTATION, DOSE = ("1.2.840.10008.5.1.4.1.1.7.3", "1.2.840.10008.5.1.4.1.1.66.4",
                               "1.2.840.10008.5.1.4.1.1.481.2")


def item(**elements):
    """A data set of these elements by keyword; lists of data sets become sequences."""
    d = Dataset()
    put(d, elements)
    return d


def put(d, elements):
    for key, value in elements.items():
        if isinstance(value, list) and value and isinstance(value[0], Dataset):
            value = Sequence(value)
        if isinstance(key, str) and key.startswith("x"):  # x0019100cIS: a private element, and its type
            d.add_new(int(key[1:9], 16), key[9:], value)
        else:
            setattr(d, key, value)


def data_set(path, sop, pixels, *, uid="1.2.3.9", modality="CT", signed=False, implicit=False, **elements):
    """A file whose pixels are an array of rows x columns, or frames x rows x columns; further elements by keyword."""
    meta = FileMetaDataset()
    meta.MediaStorageSOPClassUID, meta.MediaStorageSOPInstanceUID = sop, generate_uid()
    meta.TransferSyntaxUID = ImplicitVRLittleEndian if implicit else ExplicitVRLittleEndian
    d = FileDataset(path, {}, file_meta=meta, preamble=b"\0" * 128)
    d.is_little_endian, d.is_implicit_VR = True, implicit
    d.SOPClassUID, d.SOPInstanceUID, d.Modality = sop, meta.MediaStorageSOPInstanceUID, modality
    d.PatientName, d.PatientID, d.StudyInstanceUID, d.SeriesInstanceUID = "none", "none", "1.2.3", uid
    d.SeriesDescription, d.InstanceNumber = "phantom", "1"
    d.SamplesPerPixel, d.PhotometricInterpretation = 1, "MONOCHROME2"
    d.Rows, d.Columns = pixels.shape[-2:]
    if pixels.ndim == 3:
        d.NumberOfFrames = str(len(pixels))
    d.BitsAllocated = d.BitsStored = 8 * pixels.dtype.itemsize
    d.HighBit, d.PixelRepresentation = d.BitsStored - 1, int(np.issubdtype(pixels.dtype, np.signedinteger))
    d.PixelData = pixels.tobytes()
    put(d, elements)
    return d


def save(d):
    folder = os.path.dirname(d.filename)
    if folder:
        os.makedirs(folder, exist_ok=True)
    d.save_as(d.filename, write_like_original=False)


def decimals(values):
    return ["%.12g" % v for v in values]


class Grid:
    """Planes of an oblique stack: where voxels lie, LPS millimetres."""

    def __init__(self, size=(7, 5), spacing=(0.75, 1.5), gap=2.0, origin=(-10.5, 20.25, 30.125), turn=0.3):
        self.columns, self.rows = size
        self.spacing, self.gap, self.origin = spacing, gap, np.array(origin)
        c, s = np.cos(turn), np.sin(turn)
        self.x, self.y = np.array([c, s, 0]), np.array([-s * c, c * c, s])
        self.normal = np.cross(self.x, self.y)
        self.orientation = decimals([*self.x, *self.y])
        self.pixel_spacing = decimals([spacing[1], spacing[0]])

    def position(self, k):
        return self.origin + k * self.gap * self.normal

    def voxels(self, k):
        """rows x columns x 3: positions of plane k's pixels."""
        r, c = np.meshgrid(np.arange(self.rows), np.arange(self.columns), indexing="ij")
        return self.position(k) + c[..., None] * self.x * self.spacing[0] + r[..., None] * self.y * self.spacing[1]

    def values(self, k, volume=0):
        """Different at every pixel, plane and volume; whole numbers from 0."""
        r, c = np.meshgrid(np.arange(self.rows), np.arange(self.columns), indexing="ij")
        return (c + 16 * r + 200 * k + 5000 * volume).astype("<u2")


def plane_groups(grid, k):
    return {"PlanePositionSequence": [item(ImagePositionPatient=decimals(grid.position(k)))]}


def shared_groups(grid, **more):
    groups = {"PlaneOrientationSequence": [item(ImageOrientationPatient=grid.orientation)],
              "PixelMeasuresSequence": [item(PixelSpacing=grid.pixel_spacing, SliceThickness="2")]}
    groups.update(more)
    return groups


def transformation(slope, intercept):
    return {"PixelValueTransformationSequence": [item(RescaleSlope=str(slope), RescaleIntercept=str(intercept), RescaleType="US")]}


def enhanced(path, grid, frames, *, sop=ENHANCED_MR, shared=None, **elements):
    """An enhanced file. frames: pairs (plane, groups of the frame beside its position), with the group's `pixels`."""
    pixels = np.array([groups.pop("pixels") if "pixels" in groups else grid.values(k) for k, groups in frames])
    d = data_set(path, sop, pixels, **{"modality": "MR", **elements})
    d.SharedFunctionalGroupsSequence = Sequence([item(**(shared_groups(grid) if shared is None else shared))])
    d.PerFrameFunctionalGroupsSequence = Sequence([item(**plane_groups(grid, k), **groups) for k, groups in frames])
    save(d)
    return d


def classic(path, grid, k, *, pixels=None, sop=MR, number=None, **elements):
    d = data_set(path, sop, grid.values(k) if pixels is None else pixels, **{"modality": "MR", **elements})
    d.ImagePositionPatient, d.ImageOrientationPatient = decimals(grid.position(k)), grid.orientation
    d.PixelSpacing, d.InstanceNumber = grid.pixel_spacing, str(k + 1 if number is None else number)
    put(d, elements)
    for name in [key for key, value in elements.items() if value is None and key in d]:
        delattr(d, name)
    save(d)
    return d


TYPES = {"NumberOfImagesInMosaic": b"US\0\0", "AcquisitionMatrixText": b"SH\0\0", "MrPhoenixProtocol": b"UN\0\0"}


def csa_header(tags):
    """Siemens' private header of version 2, as nibabel.nicom.csareader reads it. tags: name -> texts."""
    out = b"SV10\4\3\2\1" + struct.pack("<II", len(tags), 77)
    for name, texts in tags.items():
        out += name.encode().ljust(64, b"\0") + struct.pack("<I4sIII", len(texts), TYPES.get(name, b"FD\0\0"), 4, len(texts), 77)
        for text in texts:
            raw = text.encode() + b"\0"
            out += struct.pack("<IIII", len(raw), len(raw), 77, len(raw)) + raw.ljust((len(raw) + 3) // 4 * 4, b"\0")
    return out


def mosaic(path, grid, count, *, across=3, way=1, normal=None, stated=None, protocol=False, single=None, **elements):
    """Tiles of planes 0 .. count - 1 of a grid, of which plane 0 is the first tile; way -1: planes follow each other
    against the normal. normal, stated, single: what the private header has for the normal and the count."""
    picture = np.zeros((across * grid.rows, across * grid.columns), "<u2")
    for k in range(count):
        r, c = k // across * grid.rows, k % across * grid.columns
        picture[r:r + grid.rows, c:c + grid.columns] = grid.values(k)
    d = data_set(path, MR, picture, modality="MR", ImageType=["ORIGINAL", "PRIMARY", "M", "MOSAIC"], Manufacturer="SIEMENS")
    # Siemens states the position that a picture of the mosaic's size around the slice's centre would have.
    shift = (across - 1) / 2 * (grid.columns * grid.spacing[0] * grid.x + grid.rows * grid.spacing[1] * grid.y)
    d.ImagePositionPatient, d.ImageOrientationPatient = decimals(grid.origin - shift), grid.orientation
    d.PixelSpacing, d.SpacingBetweenSlices = grid.pixel_spacing, "%.10g" % grid.gap
    image, series = {"AcquisitionMatrixText": ["%d*%d" % (grid.rows, grid.columns)]}, {}
    if stated != 0:
        image["NumberOfImagesInMosaic"] = [str(stated or count)]
    if normal is not None:
        image["SliceNormalVector"] = ["%.10f" % v for v in normal]
    if protocol:
        centre = grid.origin + grid.columns / 2 * grid.spacing[0] * grid.x + grid.rows / 2 * grid.spacing[1] * grid.y
        order = range(count) if way > 0 else range(count - 1, -1, -1)
        lines = ["sSliceArray.lSize = %d" % count]
        for n, k in enumerate(order):
            place = centre + way * k * grid.gap * grid.normal
            lines += ["sSliceArray.asSlice[%d].sPosition.%s = %.9f" % (n, axis, v) for axis, v in zip(("dSag", "dCor", "dTra"), place)]
            lines += ["sSliceArray.asSlice[%d].dThickness = 2" % n]
        series["MrPhoenixProtocol"] = ["### ASCCONV BEGIN ###\n" + "\n".join(lines) + "\n### ASCCONV END ###"]
    d.add_new(0x00290010, "LO", "SIEMENS CSA HEADER")
    d.add_new(0x00291010, "OB", csa_header(image))
    d.add_new(0x00291020, "OB", csa_header(series or {"Nothing": []}))
    if single:
        d.add_new(0x00190010, "LO", "SIEMENS MR HEADER")
        d.add_new(0x0019100A, "US", single)
    put(d, elements)
    save(d)


def segmentation(path, grid, frames, names, *, fractional=0, between=None, **elements):
    """frames: (plane, segment, mask); bits follow each other through all frames."""
    masks = np.array([mask for _, _, mask in frames])
    if fractional:
        pixels = masks.astype(np.uint8)
    else:
        pixels = np.packbits(masks.reshape(-1).astype(np.uint8), bitorder="little")
        pixels = np.r_[pixels, np.zeros(len(pixels) % 2, np.uint8)]
    d = data_set(path, SEGMENTATION, masks.astype(np.uint8), modality="SEG")
    d.PixelData = pixels.tobytes()
    if not fractional:
        d.BitsAllocated, d.BitsStored, d.HighBit = 1, 1, 0
    d.SegmentationType = "FRACTIONAL" if fractional else "BINARY"
    if fractional:
        d.MaximumFractionalValue, d.SegmentationFractionalType = fractional, "PROBABILITY"
    d.SegmentSequence = Sequence([item(SegmentNumber=n, SegmentLabel=name) for n, name in names.items()])
    measures = item(PixelSpacing=grid.pixel_spacing, SliceThickness="2")
    if between:
        measures.SpacingBetweenSlices = str(between)
    d.SharedFunctionalGroupsSequence = Sequence([item(PlaneOrientationSequence=[item(ImageOrientationPatient=grid.orientation)],
                                                      PixelMeasuresSequence=[measures])])
    d.PerFrameFunctionalGroupsSequence = Sequence(
        [item(**plane_groups(grid, k), SegmentIdentificationSequence=[item(ReferencedSegmentNumber=s)]) for k, s, _ in frames])
    put(d, elements)
    save(d)
