#pragma once

#include <string>

/// Numbers in units that people read, for messages; files for programs keep the raw numbers.
namespace slicemorph {

/// A count: "9876", "123,456", from a million on by two digits at least, "1.2 million", "123 million", "4.5 billion".
std::string readableCount(double count);
/// A size in steps of 1024: "442 bytes", "48.3 MB", "1.5 GB".
std::string readableBytes(double bytes);
/// A time: "0.4 s", "45 s", "3 min 20 s", "2 h 10 min", "3 days 4 h". Below ten seconds one digit after the point.
std::string readableDuration(double seconds);

}  // namespace slicemorph
