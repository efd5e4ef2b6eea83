#include "engine/numerics/readable.h"

#include <gtest/gtest.h>

namespace slicemorph {
namespace {

TEST(Readable, Counts) {
  EXPECT_EQ(readableCount(0), "0");
  EXPECT_EQ(readableCount(9999), "9999");
  EXPECT_EQ(readableCount(10000), "10,000");
  EXPECT_EQ(readableCount(123456), "123,456");
  EXPECT_EQ(readableCount(999999), "999,999");
  EXPECT_EQ(readableCount(1000000), "1 million");
  EXPECT_EQ(readableCount(1234567), "1.2 million");
  EXPECT_EQ(readableCount(9960000), "10 million");
  EXPECT_EQ(readableCount(123456789), "123 million");
  EXPECT_EQ(readableCount(999600000), "1 billion");
  EXPECT_EQ(readableCount(-2500000), "-2.5 million");
  EXPECT_EQ(readableCount(2.62e58), "2.62e+58");
  EXPECT_EQ(readableCount(1 / 0.0), "inf");
}

TEST(Readable, Bytes) {
  EXPECT_EQ(readableBytes(0), "0 bytes");
  EXPECT_EQ(readableBytes(1), "1 byte");
  EXPECT_EQ(readableBytes(1023), "1023 bytes");
  EXPECT_EQ(readableBytes(1024), "1 KB");
  EXPECT_EQ(readableBytes(48.3 * 1024 * 1024), "48.3 MB");
  EXPECT_EQ(readableBytes(300.0 * 1024 * 1024), "300 MB");
  EXPECT_EQ(readableBytes(1023.0 * 1024 * 1024), "0.999 GB");
  EXPECT_EQ(readableBytes(1.5 * 1024 * 1024 * 1024), "1.5 GB");
  EXPECT_EQ(readableBytes(5000.0 * 1024 * 1024 * 1024 * 1024 * 1024), "5000 PB");
  EXPECT_EQ(readableBytes(1e40), "1e+40 bytes");
}

TEST(Readable, Durations) {
  EXPECT_EQ(readableDuration(0.04), "0.0 s");
  EXPECT_EQ(readableDuration(9.94), "9.9 s");
  EXPECT_EQ(readableDuration(9.96), "10 s");
  EXPECT_EQ(readableDuration(59.4), "59 s");
  EXPECT_EQ(readableDuration(59.6), "1 min");
  EXPECT_EQ(readableDuration(200), "3 min 20 s");
  EXPECT_EQ(readableDuration(3599.7), "1 h");
  EXPECT_EQ(readableDuration(2 * 3600 + 10 * 60 + 20), "2 h 10 min");
  EXPECT_EQ(readableDuration(24 * 3600), "1 day");
  EXPECT_EQ(readableDuration(76 * 3600), "3 days 4 h");
}

}  // namespace
}  // namespace slicemorph
