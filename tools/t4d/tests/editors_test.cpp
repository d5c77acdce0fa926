#include <algorithm>
#include <cstring>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include <gmock/gmock.h>

#include "formats/t4d/chunk_list.h"
#include "formats/t4d/join.h"
#include "formats/t4d/metadata.h"
#include "formats/t4d/test_slabs.h"
#include "tools/t4d/tests/test_folder.h"

/// What editors do with what they do not know, and with attributes: rules E1 to E7 of SPEC.md.
namespace t4d::tools {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

using Chunks = std::vector<std::pair<std::string, std::string>>;  // types and texts

const Chunks kChunks = {{"note", "first"},  {"acmE", "of the mesh"}, {"PADD", ""},
                        {"acMe", "second"}, {"note", "third"},       {"nEw1", "a number"}};

constexpr const char* kOthers = R"({"acme:project":{"id":[1,2.5]},"later":true})";

/// A file without index with these chunks between HEAD and the others.
void putChunks(const fs::path& path, const Chunks& chunks, std::uint32_t flags = 0) {
  using namespace formats::t4d_layout;
  std::string bytes = contents(path);
  const auto all = formats::listChunks(bytes);
  std::uint64_t count = 0;
  std::memcpy(&count, bytes.data() + all.back().fields(), sizeof count);
  count += chunks.size();
  formats::overwrite(bytes, all.back().fields(), count);
  std::string inserted;
  for (const auto& [type, text] : chunks) {
    PayloadWriter payload;
    payload.putBytes(text.data(), text.size());
    ChunkType letters{};
    std::ranges::copy(type, letters.begin());
    auto [header, front] = formats::frontOf(letters, payload, 0, flags);
    const auto encoded = formats::encodeChunkHeader(header);
    inserted.append(reinterpret_cast<const char*>(encoded.data()), encoded.size());
    front.pad();
    inserted.append(reinterpret_cast<const char*>(front.data()), front.size());
  }
  bytes.insert(all.front().end(), inserted);
  formats::repairChecksums(bytes);
  std::ofstream(path, std::ios::binary) << bytes;
}

model::Attribute attributeOf(const std::string& name, const std::vector<double>& values,
                             std::uint32_t components, model::Domain domain) {
  model::Attribute attribute = model::makeAttribute(name, domain, values);
  attribute.components = components;
  return attribute;
}

/// A simplex with attributes of all kinds, and metadata of all sorts.
model::Slab simplexWithAttributes() {
  model::Slab slab = formats::simplexSlab();
  const std::size_t vertices = slab.vertices.size();
  const std::size_t cells = slab.connectivity->cells.size();
  const auto rows = [](std::size_t count, std::initializer_list<double> row) {
    std::vector<double> values;
    for (std::size_t i = 0; i < count; ++i) values.insert(values.end(), row);
    return values;
  };
  using model::Domain;
  slab.attributes = {attributeOf("velocity", rows(vertices, {2, 0, 0}), 3, Domain::Vertex),
                     attributeOf("force", rows(vertices, {0, 3, 0}), 3, Domain::Vertex),
                     attributeOf("target", rows(vertices, {1, 2, 3}), 3, Domain::Vertex),
                     attributeOf("up", rows(vertices, {0, 1, 0}), 3, Domain::Vertex),
                     attributeOf("thickness", rows(vertices, {4}), 1, Domain::Vertex),
                     attributeOf("color", rows(cells, {1, 0.5, 0}), 3, Domain::Cell),
                     attributeOf("region", rows(cells, {7}), 1, Domain::Cell),
                     attributeOf("curl", rows(cells, {1, 2, 3}), 3, Domain::Cell)};
  return slab;
}

class Editors : public InFolder {
 protected:
  fs::path at(const std::string& name) const { return folder_ / name; }

  formats::Metadata metadata() const {
    formats::Metadata metadata = formats::metadataOf({"simplex"});
    metadata.space = "RAS";
    metadata.attributes = {{"force", {"vector", "N", R"({"acme:colormap":"hot"})"}},
                           {"target", {"point", ""}},
                           {"up", {"normal", ""}},
                           {"thickness", {"scalar", "length"}},
                           {"region", {"label", ""}},
                           {"curl", {"tensor", ""}}};
    metadata.otherJson = kOthers;
    metadata.bodies[0].otherJson = R"({"acme:part":12})";
    return metadata;
  }

  /// A file that lasts from `begin` on for 1.
  fs::path write(const std::string& name, const formats::Metadata& metadata, const Chunks& chunks,
                 double begin = 0) const {
    auto writer = formats::T4dWriter::create(at(name), metadata, {.index = false});
    EXPECT_TRUE(writer) << writer.error().text();
    model::Slab slab = simplexWithAttributes();
    slab.timeBegin += begin;
    slab.timeEnd += begin;
    for (model::Point4& vertex : slab.vertices) vertex[3] += begin;
    const auto put = writer->body(0).put(slab);
    EXPECT_TRUE(put) << put.error().text();
    EXPECT_TRUE(writer->finish());
    putChunks(at(name), chunks);
    EXPECT_TRUE(formats::checkT4dFile(at(name)));
    return at(name);
  }

  /// The optional chunks of a file, and their texts.
  static Chunks chunksOf(const fs::path& path) {
    const std::string bytes = contents(path);
    Chunks found;
    for (const formats::ChunkHeader& chunk : formats::listChunks(bytes)) {
      if (!chunk.critical()) {
        found.emplace_back(chunk.name(), bytes.substr(chunk.payload(), chunk.payloadBytes));
      }
    }
    return found;
  }

  static formats::Metadata metadataIn(const fs::path& path) {
    const auto reader = formats::T4dReader::open(path, formats::T4dOpen::Checked);
    EXPECT_TRUE(reader) << reader.error().text();
    return reader ? reader->metadata() : formats::Metadata();
  }

  /// The first rows of the attributes of the first slab.
  static std::map<std::string, std::vector<double>> rowsIn(const fs::path& path) {
    const auto reader = formats::T4dReader::open(path);
    const auto slab = *reader->body(0).slab(0);
    std::map<std::string, std::vector<double>> rows;
    for (const auto* all : {&slab->attributes, &slab->connectivity->cellAttributes}) {
      for (const model::Attribute& attribute : *all) {
        std::vector<double>& row = rows[attribute.name];
        row.resize(attribute.components);
        std::memcpy(row.data(), attribute.values.data(), attribute.rowBytes());
      }
    }
    return rows;
  }
};

const Chunks kSafe = {{"note", "first"}, {"acMe", "second"}, {"note", "third"}};

TEST_F(Editors, KeepWhatMayBeKeptAndNameTheRest) {
  write("in.t4d", metadata(), kChunks);
  write("far.t4d", formats::metadataOf({"far"}), {}, 5);
  for (const std::string edit :
       {"compress in.t4d", "compress in.t4d --precision float32", "transform in.t4d --move 1 2 3",
        "filter in.t4d --from 0.25 --to 0.75", "quality in.t4d", "recover in.t4d", "join in.t4d",
        "resolve far.t4d in.t4d --ignore-units", "convert in.t4d --accept-loss"}) {
    const bool converts = edit.starts_with("convert");
    const Finished done = run(edit + (converts ? " out.t4d" : " -o out.t4d"));
    EXPECT_EQ(done.exitCode, converts ? 0 : 3) << edit << ": " << done.err;
    EXPECT_THAT(done.err, HasSubstr("chunk 'acmE'")) << edit;
    EXPECT_THAT(done.err, HasSubstr("chunk 'nEw1'")) << edit;
    EXPECT_THAT(done.err, Not(HasSubstr("'note'"))) << edit;
    EXPECT_THAT(done.err, Not(HasSubstr("PADD"))) << edit;
    Chunks kept = chunksOf(at("out.t4d"));
    std::erase_if(kept, [](const auto& chunk) { return chunk.first == "PADD"; });
    EXPECT_EQ(kept, kSafe) << edit;
    const formats::Metadata after = metadataIn(at("out.t4d"));
    EXPECT_EQ(json::parse(after.otherJson), json::parse(kOthers)) << edit;
    EXPECT_EQ(after.bodies[0].otherJson, metadata().bodies[0].otherJson) << edit;
    EXPECT_EQ(after.attributes, metadata().attributes) << edit;
    EXPECT_EQ(after.space, "RAS") << edit;
    EXPECT_EQ(contents(at("out.t4d"))[10], 1) << edit;  // the minor version
    EXPECT_TRUE(formats::checkT4dFile(at("out.t4d"))) << edit;
    fs::remove(at("out.t4d"));
  }
}

TEST_F(Editors, RecoverSaysWhereTheChunksAreThatItLeavesOut) {
  const std::string bytes = contents(write("in.t4d", metadata(), kChunks));
  const Finished done = run("recover in.t4d -o out.t4d");
  for (const formats::ChunkHeader& chunk : formats::listChunks(bytes)) {
    if (chunk.name() != "acmE" && chunk.name() != "nEw1") continue;
    EXPECT_THAT(done.err, HasSubstr("byte " + std::to_string(chunk.offset) + ": 1 chunk '" +
                                    chunk.name() + "'"));
  }
}

/// Formats of other programs keep no metadata.
TEST_F(Editors, ConvertNamesTheMetadataThatItLosesToOtherFormats) {
  write("in.t4d", metadata(), kChunks);
  for (const std::string format : {"vtu", "mesh", "g4tf", "node"}) {
    const Finished done = run("convert in.t4d out." + format);
    EXPECT_EQ(done.exitCode, 3) << done.err;
    for (const char* named : {": RAS\n", "force", "curl", "acme:part, acme:project, later\n",
                              ": acMe, acmE, nEw1, note\n"}) {
      EXPECT_THAT(done.err, HasSubstr(named)) << format;
    }
  }
}

TEST_F(Editors, SayNothingWhereNothingIsLost) {
  write("in.t4d", metadata(), kSafe);
  for (const std::string edit : {"compress in.t4d", "recover in.t4d", "filter in.t4d --from 0.5"}) {
    const Finished done = run(edit + " -o out.t4d");
    EXPECT_EQ(done.exitCode, 0) << edit << ": " << done.err;
    EXPECT_EQ(chunksOf(at("out.t4d")), kSafe) << edit;
  }
}

TEST_F(Editors, RefuseCriticalChunksThatTheyDoNotKnow) {
  write("in.t4d", metadata(), {});
  putChunks(at("in.t4d"), {{"NEED", "x"}}, formats::t4d_layout::kFlagCritical);
  const Finished done = run("compress in.t4d -o out.t4d");
  EXPECT_EQ(done.exitCode, 4);
  EXPECT_THAT(done.err, HasSubstr("NEED"));
  EXPECT_FALSE(fs::exists(at("out.t4d")));
}

TEST_F(Editors, JoinKeepsWhatTheFilesAgreeOn) {
  formats::Metadata other = metadata();
  other.otherJson = R"({"acme:project":{"id":[1,3]},"later":true,"newer":null})";
  write("first.t4d", metadata(), {{"note", "a"}, {"note", "b"}});
  write("second.t4d", other, {{"note", "b"}, {"note", "c"}}, 1);
  const Finished done = run("join first.t4d second.t4d -o out.t4d");
  EXPECT_EQ(done.exitCode, 3) << done.err;
  EXPECT_THAT(done.err, HasSubstr("member 'acme:project' of the metadata"));
  EXPECT_EQ(chunksOf(at("out.t4d")), (Chunks{{"note", "a"}, {"note", "b"}, {"note", "c"}}));
  EXPECT_EQ(json::parse(metadataIn(at("out.t4d")).otherJson),
            json::parse(R"({"later":true,"newer":null})"));

  other.attributes["force"].kind = "point";
  write("third.t4d", other, {}, 1);
  const Finished unlike = run("join first.t4d third.t4d -o unlike.t4d");
  EXPECT_EQ(unlike.exitCode, 4);
  EXPECT_THAT(unlike.err, HasSubstr("its attribute 'force'"));
  other = metadata();
  other.space = "LPS";
  write("fourth.t4d", other, {}, 1);
  EXPECT_EQ(run("join first.t4d fourth.t4d -o unlike.t4d").exitCode, 4);
  EXPECT_FALSE(fs::exists(at("unlike.t4d")));
}

TEST_F(Editors, TransformMapsAttributesByTheirKinds) {
  write("in.t4d", metadata(), {});
  const auto near = [](const std::vector<double>& values) {
    return testing::Pointwise(testing::DoubleNear(1e-12), values);
  };
  const Finished turned =
      run("transform in.t4d --scale 2 --rotate 0 0 1 90 --move 0 0 1 "
          "--time-scale 4 -o out.t4d");
  EXPECT_EQ(turned.exitCode, 3) << turned.err;
  EXPECT_THAT(turned.err, HasSubstr("attribute 'curl': the kind 'tensor' is not known"));
  auto rows = rowsIn(at("out.t4d"));
  EXPECT_THAT(rows.at("velocity"), near({0, 1, 0}));
  EXPECT_THAT(rows.at("force"), near({-3, 0, 0}));
  EXPECT_THAT(rows.at("target"), near({-4, 2, 7}));
  EXPECT_THAT(rows.at("up"), near({-1, 0, 0}));
  EXPECT_THAT(rows.at("thickness"), near({8}));
  EXPECT_THAT(rows.at("color"), near({1, 0.5, 0}));
  EXPECT_THAT(rows.at("region"), near({7}));
  EXPECT_FALSE(rows.contains("curl"));

  const Finished sheared = run("transform in.t4d --matrix 1 1 0 0 0 1 0 0 0 0 -1 0 -o out.t4d");
  EXPECT_EQ(sheared.exitCode, 3);
  EXPECT_THAT(sheared.err, HasSubstr("attribute 'force'"));
  EXPECT_THAT(sheared.err, HasSubstr("attribute 'thickness'"));
  EXPECT_THAT(sheared.err, HasSubstr("still called RAS"));
  rows = rowsIn(at("out.t4d"));
  EXPECT_THAT(rows.at("velocity"), near({2, 0, 0}));
  EXPECT_THAT(rows.at("target"), near({3, 2, -3}));
  EXPECT_THAT(rows.at("up"), near({0, 1, 0}));

  const Finished exchanged = run("transform in.t4d --axes xtzy -o out.t4d");
  EXPECT_EQ(exchanged.exitCode, 3);
  EXPECT_THAT(exchanged.err, HasSubstr("space RAS"));
  EXPECT_THAT(exchanged.err, HasSubstr("velocity"));
  EXPECT_EQ(metadataIn(at("out.t4d")).space, "");
  run("transform in.t4d --axes -x-yz --space LPS -o out.t4d");
  EXPECT_EQ(metadataIn(at("out.t4d")).space, "LPS");
}

/// No file that `validate` does not accept comes with exit code 0.
TEST_F(Editors, RefuseToWriteWhatVanishesInDoubles) {
  write("in.t4d", formats::metadataOf({"simplex"}), {});
  for (const char* map :
       {"--scale 1e-200", "--scale 1e-80",
        "--scale 1e-160 --matrix 1e-160 0 0 0 0 1e-160 0 0 0 0 1e-160 0", "--time-scale 1e-300",
        "--time-scale 1e-320", "--scale 1e80", "--scale 1 1e-90 1", "--time-scale 1e80",
        "--time-shift 1e20", "--move 1e17 0 0"}) {
    const Finished done = run(std::string("transform in.t4d -o out.t4d ") + map);
    EXPECT_EQ(done.exitCode, 4) << map << ": " << done.err;
    EXPECT_FALSE(fs::exists(at("out.t4d"))) << map;
  }
  for (const char* map : {"--scale 1e-60", "--time-scale 1e-60", "--scale 1e69", "--scale -1e-69",
                          "--matrix 1 1e9 0 0 0 1 0 0 0 0 1 0"}) {
    const Finished done = run(std::string("transform in.t4d -o out.t4d ") + map);
    EXPECT_EQ(done.exitCode, 0) << map << ": " << done.err;
    EXPECT_EQ(run("validate out.t4d").exitCode, 0) << map;
  }
  // Rounding to float32 makes all of it flat.
  ASSERT_EQ(run("transform in.t4d --scale 1e-60 -o tiny.t4d").exitCode, 0);
  EXPECT_EQ(run("compress tiny.t4d --precision float32 -o out.t4d").exitCode, 3);

  model::Slab slab = formats::simplexSlab();
  for (model::Point4& vertex : slab.vertices) vertex.head<3>() *= 1e-120;
  auto writer = formats::T4dWriter::create(at("library.t4d"), formats::metadataOf({"simplex"}));
  ASSERT_TRUE(writer->body(0).put(slab));
  const auto finished = writer->finish();
  ASSERT_FALSE(finished);
  EXPECT_THAT(finished.error().message, HasSubstr("hypervolume vanishes"));
}

TEST_F(Editors, ReadersIgnoreNewMembersOfAnotherForm) {
  for (const char* members :
       {R"("space":"FRONT")", R"("space":7)", R"("attributes":[])", R"("attributes":{"a":1})",
        R"("attributes":{"a":{"kind":1}})", R"("attributes":{"a":{"unit":[]}})"}) {
    const std::string head =
        std::string(R"({"features":[],"bodies":[{"name":"b"}],)") + members + "}";
    const auto parsed = formats::parseHead(head);
    ASSERT_TRUE(parsed) << members;
    EXPECT_EQ(parsed->space, "");
    EXPECT_THAT(parsed->attributes, IsEmpty());
    const auto text = formats::headText(*parsed, {});
    EXPECT_EQ(json::parse(*text),
              json::parse(head).patch(json::parse(R"([{"op":"add","path":"/up","value":"y"}])")));
    EXPECT_EQ(formats::minorVersionFor(*parsed), 0);
  }
  const auto parsed = formats::parseHead(
      R"({"features":[],"bodies":[{"name":"b"}],"attributes":{"a":{"kind":"tensor"}}})");
  EXPECT_EQ(parsed->attributes.at("a").kind, "tensor");
  EXPECT_EQ(formats::minorVersionFor(*parsed), 1);
}

}  // namespace
}  // namespace t4d::tools
