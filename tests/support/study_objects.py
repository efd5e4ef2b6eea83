"""DICOM files that tests write and read by pydicom, and what other programs say of them."""
import os
import subprocess

import numpy as np
import pydicom
from pydicom.dataset import FileDataset, FileMetaDataset
from pydicom.uid import CTImageStorage, ExplicitVRLittleEndian, generate_uid


def write_ct(folder, positions, size=(40, 48), spacing=(0.9, 0.7), orientation=(1, 0, 0, 0, 1, 0), value=None):
    """A whole CT series with its first pixels at `positions`; spacing between rows, between columns."""
    os.makedirs(folder, exist_ok=True)
    study, series, frame = generate_uid(), generate_uid(), generate_uid()
    for n, position in enumerate(positions):
        meta = FileMetaDataset()
        meta.MediaStorageSOPClassUID, meta.MediaStorageSOPInstanceUID = CTImageStorage, generate_uid()
        meta.TransferSyntaxUID = ExplicitVRLittleEndian
        path = os.path.join(folder, "%03d.dcm" % n)
        d = FileDataset(path, {}, file_meta=meta, preamble=b"\0" * 128)
        d.is_little_endian, d.is_implicit_VR = True, False
        d.SOPClassUID, d.SOPInstanceUID = CTImageStorage, meta.MediaStorageSOPInstanceUID
        d.StudyInstanceUID, d.SeriesInstanceUID, d.FrameOfReferenceUID = study, series, frame
        d.SpecificCharacterSet = "ISO_IR 100"
        d.PatientName, d.PatientID, d.PatientBirthDate, d.PatientSex = "Müller^Anna", "P 17", "19700102", "F"
        d.StudyDate, d.StudyTime, d.StudyID, d.AccessionNumber, d.ReferringPhysicianName = "20260102", "101500", "5", "A7", ""
        d.Modality, d.SeriesNumber, d.InstanceNumber, d.PositionReferenceIndicator = "CT", 1, n + 1, ""
        d.ImagePositionPatient = ["%.10g" % v for v in position]
        d.ImageOrientationPatient = ["%.10g" % v for v in orientation]
        d.PixelSpacing, d.SliceThickness = ["%.10g" % v for v in spacing], "1"
        d.Rows, d.Columns = size
        d.SamplesPerPixel, d.PhotometricInterpretation = 1, "MONOCHROME2"
        d.BitsAllocated, d.BitsStored, d.HighBit, d.PixelRepresentation = 16, 16, 15, 0
        d.RescaleSlope, d.RescaleIntercept, d.ImageType = "1", "-1024", ["ORIGINAL", "PRIMARY", "AXIAL"]
        pixels = np.full(size, 1000 + n) if value is None else value[n]
        d.PixelData = pixels.astype("<u2").tobytes()
        d.save_as(path)


def errors_of(path):
    """What dciodvfy of dicom3tools finds wrong with a file."""
    result = subprocess.run(["dciodvfy", path], capture_output=True, text=True, errors="replace")
    return [line for line in (result.stderr + result.stdout).splitlines() if line.startswith("Error")]


def segment_masks(path):
    """Masks of a binary segmentation by segment's label: [(position, mask of rows x columns)], and the data set."""
    d = pydicom.dcmread(path)
    bits = np.unpackbits(np.frombuffer(d.PixelData, np.uint8), bitorder="little")
    frames = bits[:d.NumberOfFrames * d.Rows * d.Columns].reshape(d.NumberOfFrames, d.Rows, d.Columns).astype(bool)
    names = {s.SegmentNumber: s.SegmentLabel for s in d.SegmentSequence}
    masks = {name: [] for name in names.values()}
    for frame, groups in zip(frames, d.PerFrameFunctionalGroupsSequence):
        number = groups.SegmentIdentificationSequence[0].ReferencedSegmentNumber
        masks[names[number]].append((np.array(groups.PlanePositionSequence[0].ImagePositionPatient, float), frame))
    return masks, d


def steps_of(segmentation):
    """Vectors from a pixel to the next one along a row, and along a column."""
    shared = segmentation.SharedFunctionalGroupsSequence[0]
    direction = np.array(shared.PlaneOrientationSequence[0].ImageOrientationPatient, float)
    between_rows, between_columns = [float(v) for v in shared.PixelMeasuresSequence[0].PixelSpacing]
    return direction[:3] * between_columns, direction[3:] * between_rows


def points_inside(polygon, points):
    """Even-odd rule, N x 2 points."""
    inside = np.zeros(len(points), bool)
    x, y = points.T
    with np.errstate(divide="ignore", invalid="ignore"):
        for (ax, ay), (bx, by) in zip(polygon, np.roll(polygon, -1, 0)):
            crosses = (ay > y) != (by > y)
            inside ^= crosses & (x < (bx - ax) * (y - ay) / (by - ay) + ax)
    return inside
