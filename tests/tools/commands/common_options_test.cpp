#include "tools/commands/common_options.h"

#include <gtest/gtest.h>

namespace slicemorph {
namespace {

TEST(Notes, AreToldByTheirSeverity) {
  const Notes notes = {{"frame.turned", Severity::kNote, "", "turned"},
                       {"map.torn", Severity::kWarning, "", "torn"},
                       {"mesh.open", Severity::kWarning, "b.ply", "open"},
                       {"match.overlap", Severity::kDetail, "", "overlap 0.5"}};
  testing::internal::CaptureStderr();
  printNotes("", notes, false);
  printNotes("a.ply: ", {{"mesh.thin", Severity::kWarning, "", "thin"}}, false);
  printNotes("", notes, true);
  EXPECT_EQ(testing::internal::GetCapturedStderr(),
            "note: turned\nwarning: torn\nwarning: b.ply: open\nwarning: a.ply: thin\n");
  testing::internal::CaptureStderr();
  printNotes("", {notes[3]}, false, true);
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "note: overlap 0.5\n");
}

}  // namespace
}  // namespace slicemorph
