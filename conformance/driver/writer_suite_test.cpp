#include "conformance/driver/writer_suite.h"

#include <algorithm>
#include <set>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "platform/test_folder.h"
#include "t4d/file.h"

namespace t4d::conformance {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class WriterSuite : public testing::Test {
 protected:
  fs::path written(const WriterCase& test, const formats::T4dWriteOptions& options = {}) {
    const fs::path path = folder_ / "out.t4d";
    auto writer = formats::T4dWriter::create(path, test.metadata, options);
    EXPECT_TRUE(writer) << writer.error().text();
    for (std::size_t i = 0; i < test.bodies.size(); ++i) {
      const auto put = pump(test.bodies[i], writer->body(i));
      EXPECT_TRUE(put) << test.id << put.error().text();
    }
    const auto finished = writer->finish();
    EXPECT_TRUE(finished) << finished.error().text();
    return path;
  }

  platform::TestFolder folder_;
};

WriterCase writerCase(const std::string& id) {
  for (WriterCase& test : writerCases()) {
    if (test.id == id) return std::move(test);
  }
  ADD_FAILURE() << "no case " << id;
  return {};
}

model::Mesh withSlab(const model::Mesh& mesh, std::size_t slab,
                     const std::function<void(model::Slab&)>& change) {
  model::Mesh result;
  for (std::size_t i = 0; i < mesh.slabCount(); ++i) {
    model::Slab copy = mesh.slabs()[i];
    if (i == slab) change(copy);
    EXPECT_TRUE(result.put(copy));
  }
  return result;
}

TEST_F(WriterSuite, OurWriterHasNoFaults) {
  std::set<std::string> kinds;
  for (const WriterCase& test : writerCases()) {
    kinds.insert(kindOf(test.id));
    for (const int compression : {0, 3}) {
      EXPECT_THAT(faultsOf(test, written(test, {.compression = compression})), IsEmpty())
          << test.id;
    }
  }
  EXPECT_THAT(kinds, ElementsAre("attributes", "bodies", "head", "means", "plain"));
}

TEST_F(WriterSuite, EveryDifferenceIsAFault) {
  const WriterCase test = writerCase("plain/cross-polytope");
  const auto faults = [&](std::size_t slab, const std::function<void(model::Slab&)>& change) {
    WriterCase other = test;
    other.bodies[0] = withSlab(test.bodies[0], slab, change);
    return testing::PrintToString(faultsOf(other, written(test)));
  };
  EXPECT_THAT(faults(0, [](model::Slab& slab) { slab.timeBegin = -2; }),
              HasSubstr("begin of slab 0 of body 0 is -1; expected -2"));
  EXPECT_THAT(faults(1, [](model::Slab& slab) { slab.vertices[6][0] = -0.0; }),
              HasSubstr("vertex 6 of slab 1 of body 0 is (0, 0, 0, 1); expected (-0, 0, 0, 1)"));
  EXPECT_THAT(faults(1,
                     [](model::Slab& slab) {
                       auto turned = std::make_shared<model::Connectivity>(*slab.connectivity);
                       std::swap(turned->cells[2][0], turned->cells[2][1]);
                       slab.connectivity = turned;
                     }),
              HasSubstr("cell 2 of slab 1 of body 0 is (3, 0, 4, 6); expected (0, 3, 4, 6)"));
  EXPECT_THAT(faults(0,
                     [](model::Slab& slab) {
                       slab.attributes = {
                           model::makeAttribute("a", model::Domain::Cell, std::vector<double>(8))};
                     }),
              HasSubstr("the attributes of slab 0 of body 0, per cell are none; expected 'a'"));
  WriterCase named = test;
  named.metadata.bodies[0].name = "other";
  named.metadata.lengthUnit = "mm";
  EXPECT_THAT(
      faultsOf(named, written(test)),
      ElementsAre("length_unit is ; expected mm", "the name of body 0 is cross; expected other"));
  WriterCase longer = test;
  longer.bodies[0] = withSlab(test.bodies[0], 0, [](model::Slab&) {});
  longer.bodies.push_back(test.bodies[0]);
  longer.metadata.bodies.push_back({"second"});
  EXPECT_THAT(faultsOf(longer, written(test)),
              ElementsAre("the number of bodies is 1; expected 2"));
}

/// `test` with every slab changed.
WriterCase changed(WriterCase test, const std::function<void(model::Slab&)>& change) {
  for (model::Mesh& body : test.bodies) {
    model::Mesh other;
    for (model::Slab slab : body.slabs()) {
      change(slab);
      if (!other.put(slab)) break;
    }
    body = std::move(other);
  }
  return test;
}

TEST_F(WriterSuite, WhateverAWriterLeavesOutSomeCaseMisses) {
  using formats::BodyInfo;
  using formats::Metadata;
  using model::Slab;
  std::vector<WriterCase> cases = writerCases();
  std::erase_if(cases, [](const WriterCase& test) {
    constexpr std::size_t kFew = 500;
    return std::ranges::any_of(test.bodies, [](const model::Mesh& body) {
      return std::ranges::any_of(
          body.slabs(), [](const Slab& slab) { return slab.connectivity->cells.size() > kFew; });
    });
  });
  const auto expectMissed = [&](const char* what, const std::function<WriterCase(WriterCase)>& by) {
    EXPECT_TRUE(std::ranges::any_of(cases, [&](const WriterCase& test) {
      return !faultsOf(test, written(by(test))).empty();
    })) << what;
  };
  const auto ofHead = [&](const char* what, const std::function<void(Metadata&)>& forget) {
    expectMissed(what, [&](WriterCase test) {
      forget(test.metadata);
      return test;
    });
  };
  const auto ofBodies = [&](const char* what, const std::function<void(BodyInfo&)>& forget) {
    ofHead(what, [&](Metadata& head) { std::ranges::for_each(head.bodies, forget); });
  };
  const auto ofSlabs = [&](const char* what, const std::function<void(Slab&)>& forget) {
    expectMissed(what, [&](const WriterCase& test) { return changed(test, forget); });
  };
  ofHead("length_unit", [](Metadata& head) { head.lengthUnit.clear(); });
  ofHead("time_unit", [](Metadata& head) { head.timeUnit.clear(); });
  ofHead("up", [](Metadata& head) { head.up = "y"; });
  ofHead("backend", [](Metadata& head) { head.backend.clear(); });
  ofHead("details", [](Metadata& head) { head.detailsJson = "{}"; });
  ofBodies("color", [](BodyInfo& body) { body.color.clear(); });
  ofBodies("opacity",
           [](BodyInfo& body) { body.color.resize(std::min<std::size_t>(body.color.size(), 3)); });
  ofBodies("material", [](BodyInfo& body) { body.material.clear(); });
  ofBodies("parent", [](BodyInfo& body) { body.parent.clear(); });
  ofBodies("details of a body", [](BodyInfo& body) { body.detailsJson = "{}"; });
  for (const model::Domain domain : {model::Domain::Vertex, model::Domain::Cell}) {
    ofSlabs("attributes of vertices, or cells", [&](Slab& slab) {
      std::erase_if(slab.attributes, [&](const auto& each) { return each.domain == domain; });
    });
    ofSlabs("the second of these attributes", [&](Slab& slab) {
      int seen = 0;
      std::erase_if(slab.attributes,
                    [&](const auto& each) { return each.domain == domain && seen++ > 0; });
    });
  }
  ofSlabs("attributes of a connectivity", [](Slab& slab) {
    auto other = std::make_shared<model::Connectivity>(*slab.connectivity);
    other->cellAttributes.clear();
    slab.connectivity = other;
  });
  ofSlabs("that a vertex is a mean", [](Slab& slab) {
    auto other = std::make_shared<model::Connectivity>(*slab.connectivity);
    other->means = {};
    slab.connectivity = other;
  });
  ofSlabs("the order of cells", [](Slab& slab) {
    auto other = std::make_shared<model::Connectivity>(*slab.connectivity);
    std::ranges::reverse(other->cells);
    slab.connectivity = other;
  });
  ofSlabs("the sign of zero", [](Slab& slab) {
    for (model::Point4& vertex : slab.vertices) vertex.array() += 0.0;
  });
}

TEST_F(WriterSuite, AMeshThatIsTurnedOrRoundedIsNamed) {
  const WriterCase test = writerCase("plain/cross-polytope");
  WriterCase turned = test;
  turned.bodies[0] = withSlab(test.bodies[0], 0, [](model::Slab& slab) {
    auto other = std::make_shared<model::Connectivity>(*slab.connectivity);
    for (model::Cell& cell : other->cells) std::swap(cell[0], cell[1]);
    slab.connectivity = other;
  });
  EXPECT_THAT(faultsOf(test, written(turned)).front(),
              HasSubstr("body 0 is not oriented, other than the mesh in MESH.json"));
  WriterCase third = test;
  third.bodies[0] =
      withSlab(test.bodies[0], 0, [](model::Slab& slab) { slab.vertices[0][2] = 0.1; });
  EXPECT_THAT(faultsOf(third, written(third, {.float32 = true})),
              ElementsAre(HasSubstr("it is rounded to binary32; store type 10")));
  EXPECT_THAT(faultsOf(test, folder_ / "none"), ElementsAre("exited with 0 and wrote no OUT.t4d"));
}

TEST_F(WriterSuite, OutcomesAreThoseOfTheProgram) {
  const std::vector<WriterCase> cases = {writerCase("plain/one-simplex")};
  const auto outcome = [&](const std::string& script) {
    const auto reports = runWriterCases(
        cases, {.command = {"/bin/sh", "-c", script, "sh"}, .timeoutSeconds = 0.2, .keep = {}});
    EXPECT_TRUE(reports) << reports.error().text();
    return reports->front();
  };
  const fs::path right = written(cases[0]);
  EXPECT_EQ(outcome("cp " + right.string() + " \"$2\"").outcome, Outcome::Passed);
  EXPECT_EQ(outcome("true").message, "exited with 0 and wrote no OUT.t4d");
  EXPECT_THAT(outcome("head -c 100 " + right.string() + " > \"$2\"").message, HasSubstr("OUT.t4d"));
  EXPECT_EQ(outcome("exit 1").outcome, Outcome::Failed);
  EXPECT_EQ(outcome("exit 3").outcome, Outcome::Crashed);
  EXPECT_EQ(outcome("kill -9 $$").outcome, Outcome::Crashed);
  EXPECT_EQ(outcome("sleep 9").outcome, Outcome::TimedOut);
  // The mesh is the input: as many rows as there are vertices and cells.
  EXPECT_EQ(outcome("test $(grep -c '^ *\\[[0-9]' \"$1\") = 10 && cp " + right.string() + " \"$2\"")
                .outcome,
            Outcome::Passed);
}

TEST_F(WriterSuite, PartsAreListedOnce) {
  for (const WriterCase& test : writerCases()) {
    const MeshText text = textOf(test);
    const auto mesh = nlohmann::json::parse(text.json);
    EXPECT_EQ(mesh["connectivities"].size(), text.connectivities);
    std::set<std::string> connectivities;
    for (const auto& each : mesh["connectivities"]) connectivities.insert(each.dump());
    EXPECT_EQ(connectivities.size(), text.connectivities) << test.id;
    std::set<std::size_t> layers;
    for (const auto& body : mesh["bodies"]) {
      for (const auto& slab : body["slabs"]) {
        for (const char* layer : {"lower", "upper"}) {
          if (!slab[layer].is_null()) layers.insert(slab[layer].get<std::size_t>());
        }
      }
    }
    EXPECT_EQ(layers.size(), text.layers) << test.id;
  }
  EXPECT_EQ(textOf(writerCase("plain/cube-in-translation")).connectivities, 3U);
  EXPECT_EQ(textOf(writerCase("plain/cube-in-translation")).layers, 6U);
}

}  // namespace
}  // namespace t4d::conformance
