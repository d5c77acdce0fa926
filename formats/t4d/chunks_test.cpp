#include "formats/t4d/chunks.h"

#include <functional>
#include <limits>

#include <gmock/gmock.h>

#include "formats/t4d/array_codec.h"
#include "formats/t4d/index_chunk.h"
#include "formats/t4d/test_slabs.h"

/// What the decoders report for chunks with valid checksums that have one false field each.
namespace t4d::formats {
namespace {

using model::Connectivity;
using model::ScalarType;
using t4d_layout::PayloadView;
using t4d_layout::PayloadWriter;
using testing::HasSubstr;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
const ArrayOptions kRaw = {0, false};
// Decoders of files that name all features.
constexpr auto kConnectivityDecoder = [](const PayloadView& payload) {
  return decodeConnectivity(payload);
};
constexpr auto kLayerDecoder = [](const PayloadView& payload) { return decodeLayer(payload); };
constexpr auto kSlabDecoder = [](const PayloadView& payload) { return decodeSlab(payload); };
constexpr auto kIndexDecoder = [](const PayloadView& payload) { return decodeIndex(payload); };

/// A slab with these times and vertices, all in the interior.
model::Slab slabOf(const model::TimeSpan& time, const std::vector<model::Point4>& vertices,
                   const std::vector<model::Attribute>& attributes = {}) {
  auto connectivity = std::make_shared<Connectivity>();
  connectivity->vertexCount = static_cast<std::uint32_t>(vertices.size());
  return {time.begin, time.end, vertices, connectivity, attributes};
}

/// A directory of HEAD and a CONN, and so many slabs.
Index indexOf(std::size_t slabs) {
  Index index;
  index.head = "{}";
  std::uint64_t offset = t4d_layout::kFileHeaderBytes;
  for (std::size_t i = 0; i < slabs + 2; ++i) {
    ChunkHeader header;
    header.type = i == 0   ? t4d_layout::kHead
                  : i == 1 ? t4d_layout::kConnectivity
                           : t4d_layout::kSlab;
    header.offset = offset;
    offset = header.end();
    index.chunks.push_back(header);
  }
  index.slabs.resize(slabs);
  for (std::size_t i = 0; i < slabs; ++i) {
    index.slabs[i].parts.connectivity = index.chunks[i + 2].offset - index.chunks[1].offset;
    index.slabs[i].extent.emplace();
  }
  return index;
}

template <class Decoder>
std::string fault(const Decoder& decode, const PayloadWriter& payload) {
  const auto decoded = decode(payload.view());
  return decoded ? "" : decoded.error().message;
}

template <class Decoder>
void refusesEveryTruncationAndExtraBytes(const Decoder& decode, PayloadWriter payload) {
  EXPECT_EQ(fault(decode, payload), "");
  for (std::size_t length = 0; length < payload.size(); ++length) {
    EXPECT_FALSE(decode(PayloadView{payload.bytes().first(length), payload.view().blocks}))
        << length;
  }
  payload.put(std::uint64_t{0});
  EXPECT_THAT(fault(decode, payload),
              testing::AnyOf(HasSubstr("8 bytes follow"), HasSubstr("for")));
}

Connectivity connectivityWithAll() {
  Connectivity connectivity = *simplexSlab().connectivity;
  connectivity.vertexCount = 9;
  connectivity.lowerCount = 2;
  connectivity.upperCount = 2;
  for (const std::vector<std::uint32_t>& sources :
       {std::vector<std::uint32_t>{0, 1, 7}, std::vector<std::uint32_t>{2, 8}}) {
    connectivity.means.add(sources);
  }
  connectivity.cellAttributes = {
      model::makeAttribute<std::uint8_t>("kind", model::Domain::Cell, {0, 1, 2, 1, 0})};
  return connectivity;
}

TEST(Chunks, RefuseEveryTruncationAndExtraBytes) {
  refusesEveryTruncationAndExtraBytes(kConnectivityDecoder,
                                      encodeConnectivity(connectivityWithAll(), kRaw));
  const model::Slab simplex = simplexSlab();
  const std::vector<model::Attribute> attributes = {
      model::makeAttribute<double>("heat", model::Domain::Vertex, {1, 2, 3, 4, 5})};
  refusesEveryTruncationAndExtraBytes(kLayerDecoder,
                                      encodeLayer(0.5, simplex.vertices, attributes, kRaw));
  refusesEveryTruncationAndExtraBytes(
      kSlabDecoder, encodeSlab(slabOf({0, 1}, simplex.vertices, attributes), {}, kRaw));
  Done done;
  done.bodies.resize(2);
  for (BodySummary& body : done.bodies) body.slabs = 1;
  refusesEveryTruncationAndExtraBytes(decodeDone, encodeDone(done));
  refusesEveryTruncationAndExtraBytes(kIndexDecoder, encodeIndex(indexOf(3), 0));
}

/// The payload of connectivityWithAll() with one 32-bit word of its fixed part changed.
PayloadWriter connectivityWithWord(std::size_t word, std::uint32_t value) {
  return withFields(encodeConnectivity(connectivityWithAll(), kRaw),
                    [&](auto& fields) { std::memcpy(fields.data() + word * 4, &value, 4); });
}

TEST(Chunks, RefuseConnectivityWhoseCountsLie) {
  const std::uint32_t most = ~std::uint32_t{0};
  EXPECT_THAT(fault(kConnectivityDecoder, connectivityWithWord(0, 5)), HasSubstr("exceed"));
  EXPECT_THAT(fault(kConnectivityDecoder, connectivityWithWord(1, most)), HasSubstr("exceed"));
  EXPECT_THAT(fault(kConnectivityDecoder, connectivityWithWord(2, most)), HasSubstr("exceed"));
  EXPECT_THAT(fault(kConnectivityDecoder, connectivityWithWord(3, 1)), HasSubstr("sizes of 2"));
  EXPECT_THAT(fault(kConnectivityDecoder, connectivityWithWord(3, most)), HasSubstr("sizes of 2"));
  EXPECT_FALSE(decodeConnectivity(connectivityWithWord(3, 0).view()));
  EXPECT_FALSE(decodeConnectivity(connectivityWithWord(4, most).view()));
  EXPECT_THAT(fault(kConnectivityDecoder, connectivityWithWord(4, 0)), HasSubstr("bytes follow"));
  EXPECT_THAT(fault(kConnectivityDecoder, connectivityWithWord(5, most)), HasSubstr("shorter"));
}

TEST(Chunks, RefuseConnectivityThatIsUnsound) {
  const auto faultWith = [](const std::function<void(Connectivity&)>& change) {
    Connectivity connectivity = connectivityWithAll();
    change(connectivity);
    return fault(kConnectivityDecoder, encodeConnectivity(connectivity, kRaw));
  };
  EXPECT_EQ(faultWith([](Connectivity&) {}), "");
  EXPECT_THAT(faultWith([](Connectivity& c) { c.cells[2][1] = 9; }), HasSubstr("vertex 9"));
  EXPECT_THAT(faultWith([](Connectivity& c) { c.cells[2][1] = ~0U; }), HasSubstr("vertex 4294"));
  EXPECT_THAT(faultWith([](Connectivity& c) { c.cells[2][1] = c.cells[2][3]; }),
              HasSubstr("twice"));
  EXPECT_THAT(faultWith([](Connectivity& c) { c.means.sources[1] = 9; }), HasSubstr("source 9"));
  // A mean of another, and of itself.
  EXPECT_THAT(faultWith([](Connectivity& c) { c.means.sources[1] = 6; }), HasSubstr("mean itself"));
  EXPECT_THAT(faultWith([](Connectivity& c) { c.means.sources[1] = 5; }), HasSubstr("mean itself"));
  EXPECT_THAT(faultWith([](Connectivity& c) { c.means.offsets[1] = 0; }), HasSubstr("no vertex"));
  EXPECT_THAT(faultWith([](Connectivity& c) { c.means.offsets[2] = 6; }), HasSubstr("than are"));
  EXPECT_THAT(faultWith([](Connectivity& c) { c.means.offsets[2] = 4; }),
              HasSubstr("4 sources, of which 5"));
  EXPECT_THAT(faultWith([](Connectivity& c) { c.cellAttributes[0].values.pop_back(); }),
              HasSubstr("'kind'"));
  EXPECT_THAT(
      faultWith([](Connectivity& c) { c.cellAttributes[0].domain = model::Domain::Vertex; }),
      HasSubstr("not per cell"));
}

TEST(Chunks, RefuseLayersAndSlabsWithoutSense) {
  const std::vector<model::Point4> vertices = simplexSlab().vertices;
  EXPECT_THAT(fault(kLayerDecoder, encodeLayer(kNan, vertices, {}, kRaw)),
              HasSubstr("at time nan"));
  EXPECT_THAT(fault(kLayerDecoder, encodeLayer(0, {}, {}, kRaw)), HasSubstr("no vertices"));
  EXPECT_THAT(fault(kSlabDecoder, encodeSlab(slabOf({1, 0}, {}), {}, kRaw)),
              HasSubstr("from time 1 to 0"));
  EXPECT_THAT(fault(kSlabDecoder, encodeSlab(slabOf({0, kNan}, {}), {}, kRaw)), HasSubstr("nan"));

  PayloadWriter twoColumns;
  twoColumns.put(0.0);
  twoColumns.put(std::uint64_t{0});
  ArrayView view = viewOf(std::vector<double>());
  const std::vector<double> six(6, 0);
  view = viewOf(six);
  view.components = 2;
  putArray(twoColumns, view, 0);
  EXPECT_THAT(fault(kLayerDecoder, twoColumns), HasSubstr("three numbers of type 6, 9 or 10"));
  PayloadWriter integers;
  integers.put(0.0);
  integers.put(std::uint64_t{0});
  const std::vector<std::uint64_t> whole(6, 0);
  view = viewOf(whole);
  view.components = 3;
  putArray(integers, view, 0);
  EXPECT_THAT(fault(kLayerDecoder, integers), HasSubstr("three numbers of type 6, 9 or 10"));

  // Positions of five vertices, times of four.
  const PayloadWriter five = encodeSlab(slabOf({0, 1}, vertices), {}, kRaw);
  PayloadWriter mixed;
  mixed.putBytes(five.data(), 56 + t4d_layout::kArrayHeaderBytes);
  mixed.putBlock(five.blocks()[0]);
  putArray(mixed, viewOf(std::vector<double>(4)), 0);
  EXPECT_THAT(fault(kSlabDecoder, mixed), HasSubstr("5 interior positions but 4 times"));
}

TEST(Chunks, RefuseAttributesThatCannotBe) {
  const auto slabWith = [](std::uint8_t domain, std::uint32_t nameBytes, std::byte pad) {
    PayloadWriter whole = withFields(encodeSlab(slabOf({0, 1}, {}), {}, kRaw), [](auto& fields) {
      const std::uint32_t one = 1;
      std::memcpy(fields.data() + 44, &one, 4);
    });
    whole.put(domain);
    whole.putBytes("\0\0\0", 3);
    whole.put(nameBytes);
    whole.putBytes("heat\0\0\0", 7);
    whole.put(static_cast<std::uint8_t>(pad));
    putArray(whole, viewOf(std::vector<double>()), 0);
    return fault(kSlabDecoder, whole);
  };
  EXPECT_EQ(slabWith(2, 4, std::byte{0}), "");
  EXPECT_THAT(slabWith(1, 4, std::byte{0}), HasSubstr("stores none of its own"));
  EXPECT_THAT(slabWith(0, 4, std::byte{0}), HasSubstr("unknown domain 0"));
  EXPECT_THAT(slabWith(3, 4, std::byte{0}), HasSubstr("unknown domain 3"));
  EXPECT_THAT(slabWith(2, 0, std::byte{0}), HasSubstr("name of 0 bytes"));
  EXPECT_THAT(slabWith(2, 256, std::byte{0}), HasSubstr("name of 256 bytes"));
  EXPECT_THAT(slabWith(2, ~0U, std::byte{0}), HasSubstr("name of 4294967295 bytes"));
  EXPECT_THAT(slabWith(2, 255, std::byte{0}), HasSubstr("truncated"));
  EXPECT_THAT(slabWith(2, 4, std::byte{1}), HasSubstr("padding is not zero"));
}

TEST(Chunks, RefuseLayersWhoseAttributesAreNotOfTheirVertices) {
  const std::vector<model::Point4> vertices = simplexSlab().vertices;
  const auto faultWith = [&](const model::Attribute& attribute) {
    return fault(kLayerDecoder, encodeLayer(0, vertices, std::span(&attribute, 1), kRaw));
  };
  using model::Domain;
  EXPECT_EQ(faultWith(model::makeAttribute<int>("a", Domain::Vertex, {1, 2, 3, 4, 5})), "");
  EXPECT_THAT(faultWith(model::makeAttribute<int>("a", Domain::Vertex, {1, 2, 3, 4})),
              HasSubstr("'a' has 4 rows for 5 vertices"));
  EXPECT_THAT(faultWith(model::makeAttribute<int>("a", Domain::Cell, {1, 2, 3, 4, 5})),
              HasSubstr("'a' is not one of vertices"));
  const std::vector<model::Attribute> twice(
      2, model::makeAttribute<int>("a", Domain::Vertex, {1, 2, 3, 4, 5}));
  EXPECT_THAT(fault(kLayerDecoder, encodeLayer(0, vertices, twice, kRaw)),
              HasSubstr("there are two attributes 'a'"));
  const PayloadWriter reserved = withFields(encodeLayer(0, vertices, {}, kRaw),
                                            [](auto& fields) { fields[12] = std::byte{1}; });
  EXPECT_THAT(fault(kLayerDecoder, reserved), HasSubstr("reserved bytes"));
}

TEST(Chunks, RefusePosesWithoutSense) {
  const auto decoder = [](const PayloadView& payload) { return decodePose(payload); };
  PosedLayer posed{1, 24, model::Affine3x4::Identity()};
  refusesEveryTruncationAndExtraBytes(decoder, encodePose(posed));
  t4d_layout::Features core;
  core.pose = false;
  EXPECT_FALSE(decodePose(encodePose(posed).view(), core));
  posed.pose(2, 3) = kNan;
  EXPECT_THAT(fault(decoder, encodePose(posed)), HasSubstr("not finite"));
  posed = {kNan, 24, model::Affine3x4::Identity()};
  EXPECT_THAT(fault(decoder, encodePose(posed)), HasSubstr("at time nan"));
}

TEST(Chunks, AllowAttributeNamesThatAreDifferentUtf8) {
  const auto faultOfNames = [](const std::vector<std::string>& names) -> std::string {
    std::vector<model::Attribute> attributes;
    for (const std::string& name : names)
      attributes.push_back(model::makeAttribute<int>(name, model::Domain::Cell, {}));
    const auto checked = checkStorable({}, attributes);
    return checked ? "" : checked.error().message;
  };
  EXPECT_EQ(faultOfNames({"a", "\u00e4", "\u4e2d", "\U0001F600", std::string(255, 'x')}), "");
  EXPECT_THAT(faultOfNames({"a", "a"}), HasSubstr("two attributes 'a'"));
  EXPECT_THAT(faultOfNames({""}), HasSubstr("has 0 bytes"));
  EXPECT_THAT(faultOfNames({std::string(256, 'x')}), HasSubstr("has 256 bytes"));
  for (const char* name :
       {"a/b", "a\n", "\x7F", "\u0085", "\u061c", "\u200e", "\u202e", "\u2069"}) {
    EXPECT_THAT(faultOfNames({name}), HasSubstr("is not allowed"));
  }
  // A lone continuation, overlong forms, a surrogate, beyond the last code point, cut off.
  for (const char* name :
       {"\x80", "\xC0\x80", "\xC1\xBF", "\xE0\x80\x80", "\xED\xA0\x80", "\xF0\x80\x80\x80",
        "\xF4\x90\x80\x80", "\xF8\x88\x80\x80\x80", "\xC3", "\xE4\xB8", "a\xFF"}) {
    EXPECT_THAT(faultOfNames({name}), HasSubstr("not UTF-8"));
  }
  const auto cell = model::makeAttribute<int>("a", model::Domain::Cell, {});
  const auto vertex = model::makeAttribute<int>("a", model::Domain::Vertex, {});
  EXPECT_FALSE(checkStorable(std::span(&cell, 1), std::span(&cell, 1)));
  EXPECT_TRUE(checkStorable(std::span(&cell, 1), std::span(&vertex, 1)));
}

TEST(Chunks, RefuseEndMarksAndIndexesWhoseCountsLie) {
  const auto doneOf = [](std::uint32_t count, std::uint64_t slabs, double bound) {
    Done done;
    done.bodies.resize(1);
    done.bodies[0].slabs = slabs;
    done.bodies[0].bounds.min[1] = bound;
    return fault(decodeDone, withFields(encodeDone(done), [&](auto& fields) {
                   std::memcpy(fields.data() + 8, &count, 4);
                 }));
  };
  EXPECT_EQ(doneOf(1, 1, 0), "");
  EXPECT_THAT(doneOf(2, 1, 0), HasSubstr("summaries of 2 bodies"));
  EXPECT_THAT(doneOf(~0U, 1, 0), HasSubstr("summaries of 4294967295 bodies"));
  EXPECT_THAT(doneOf(1, 0, 0), HasSubstr("no slab"));
  EXPECT_THAT(doneOf(1, 1, kNan), HasSubstr("bounds"));

  for (const std::uint32_t count : {0U, 2U, 1U << 31, ~0U}) {
    const PayloadWriter index = withFields(encodeIndex(indexOf(1), 0), [&](auto& fields) {
      std::memcpy(fields.data() + t4d_layout::kFileHeaderCopyBytes, &count, 4);
    });
    EXPECT_FALSE(decodeIndex(index.view())) << count;
  }
}

TEST(Chunks, RefuseIndexesThatNameOtherChunksAsPartsOfSlabs) {
  // HEAD, CONN, SLAB, SLAB.
  const auto faultWith = [](auto change) {
    Index index = indexOf(2);
    change(index, index.slabs[1].parts);
    return fault(kIndexDecoder, encodeIndex(index, 0));
  };
  const auto distance = [](const Index& index, std::size_t to) {
    return index.chunks[3].offset - index.chunks[to].offset;
  };
  EXPECT_EQ(faultWith([](const Index&, SlabParts&) {}), "");
  for (const std::size_t to : {0, 2, 3}) {
    EXPECT_THAT(faultWith([&](const Index& index, SlabParts& parts) {
                  parts.connectivity = distance(index, to);
                }),
                HasSubstr("has a connectivity or a layer that is none"))
        << to;
  }
  for (const std::size_t to : {0, 1, 2}) {
    for (std::uint64_t SlabParts::*layer : {&SlabParts::lower, &SlabParts::upper}) {
      EXPECT_THAT(faultWith([&](const Index& index, SlabParts& parts) {
                    parts.*layer = distance(index, to);
                  }),
                  HasSubstr("has a connectivity or a layer that is none"))
          << to;
    }
  }
  for (const int off : {-1000, -8, -1, 1, 8, 1000}) {
    EXPECT_THAT(faultWith([&](const Index& index, SlabParts& parts) {
                  parts.connectivity = distance(index, 1) + static_cast<std::uint64_t>(off);
                }),
                HasSubstr("has a connectivity or a layer that is none"))
        << off;
  }
}

}  // namespace
}  // namespace t4d::formats
