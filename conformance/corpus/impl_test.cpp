#include <map>

#include <gmock/gmock.h>

#include "conformance/corpus/cases.h"
#include "conformance/corpus/expect_answers.h"
#include "platform/test_folder.h"
#include "tools/t4d/validation.h"

namespace t4d::conformance {
namespace {

TEST(ImplFiles, AreReadRightWhereOurReaderAcceptsThem) {
  std::size_t accepted = 0;
  for (const AcceptedCase& made : implCases()) {
    SCOPED_TRACE(made.file.id);
    const platform::TestFolder folder;
    const auto file = folder.write("file.t4d", made.file.bytes);
    const auto description = describeFile(file);
    if (!description) {
      EXPECT_EQ(description.error().code, ErrorCode::InvalidInput) << description.error().text();
      continue;
    }
    ++accepted;
    expectAnswers(made.file, file, *description);
  }
  EXPECT_GT(accepted, 0U);
}

TEST(ImplFiles, WhoseMeshesAreFaultyAreFoundByTheValidator) {
  const std::map<std::string, std::string> codes = {
      {"impl/mesh-open", "facet-not-shared-by-two"},
      {"impl/mesh-doubled-cell", "facet-not-shared-by-two"},
      {"impl/mesh-cell-turned", "facet-orientation"},
      {"impl/mesh-inside-out", "inside-out"},
      {"impl/mesh-pinched", "vertex-link"},
      {"impl/mesh-half", "facet-not-shared-by-two"},
      {"impl/mesh-open-at-layer", "facet-not-shared-by-two"},
      {"impl/mesh-turned-above-layer", "facet-orientation"},
  };
  std::size_t found = 0;
  for (const AcceptedCase& made : implCases()) {
    SCOPED_TRACE(made.file.id);
    const auto code = codes.find(made.file.id);
    EXPECT_EQ(code != codes.end(),
              testing::Value(made.file.features, testing::Contains("faulty-mesh")));
    if (code == codes.end()) continue;
    ++found;
    const platform::TestFolder folder;
    const auto file = folder.write("file.t4d", made.file.bytes);
    const auto validation = tools::validate(file, {.vertexLinks = true});
    ASSERT_TRUE(validation);
    EXPECT_FALSE(validation->valid());
    EXPECT_THAT(validation->issues.issues,
                testing::Contains(testing::Field(&measure::Issue::code, code->second)));
  }
  EXPECT_EQ(found, codes.size());
}

}  // namespace
}  // namespace t4d::conformance
