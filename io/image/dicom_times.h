#pragma once

#include "io/image/dicom_volumes.h"

#include <optional>
#include <string>

namespace slicemorph {

/// Seconds since 1970 of a date and time (DICOM's DT: YYYYMMDDHHMMSS.FFFFFF, of which what stands behind may be missing),
/// or of a date and a time of their own (DA and TM). The offset from UTC is left out: a series has one. None where it is no such.
std::optional<double> secondsOfDateTime(const std::string& text);
std::optional<double> secondsOfDateTime(const std::string& date, const std::string& time);

/// The time from each volume of a series to the next.
struct DicomTimeStep {
  double seconds = 0;         ///< 0: volumes are no times, do not follow each other evenly, or it is not told
  bool byRepetition = false;  ///< taken from RepetitionTime
};
/// By the temporal positions' own offsets; else by when their slices were acquired; where neither is told, by
/// RepetitionTime.
DicomTimeStep timeStepOf(const DicomSeries& series);

}  // namespace slicemorph
