#include <functional>
#include <limits>

#include <fmt/format.h>

#include "conformance/corpus/invalid.h"
#include "conformance/corpus/shapes.h"
#include "platform/crc32c.h"

/// Faults of the file header, the order of chunks, their headers, and the footer.
namespace t4d::conformance {
namespace {

using namespace std::string_literals;

using NamedNumber = std::pair<const char*, std::uint64_t>;

std::uint32_t crc32c(std::string_view bytes) {
  return platform::crc32c(bytes.data(), bytes.size());
}

/// The checksum of PNG and zip.
std::uint32_t crc32(std::string_view bytes) {
  std::uint32_t crc = ~0U;
  for (const char byte : bytes) {
    crc ^= static_cast<unsigned char>(byte);
    for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ ((crc & 1U) != 0 ? 0xEDB88320U : 0U);
  }
  return ~crc;
}

std::string replaced(std::string bytes, std::size_t at, std::size_t size, const std::string& by) {
  return bytes.replace(at, size, by);
}

/// A chunk type, and the name of a chunk of `layered()` of that type.
struct KnownChunk {
  const char* type;
  const char* name;
};

constexpr KnownChunk kKnownChunks[] = {{"HEAD", "HEAD"},   {"CONN", "CONN 0"}, {"LAYR", "LAYR 0"},
                                       {"SLAB", "SLAB 1"}, {"DONE", "DONE"},   {"INDX", "INDX"}};

}  // namespace

void addFileHeaderFaults(InvalidCases& cases) {
  const Base base = plain();
  const std::string right = base.image.bytes();
  const auto bytes = [&](const std::string& name, const std::string& fault,
                         const std::string& wrong, std::uint64_t offset) {
    cases.addBytes(name, fault, base, wrong, offset);
  };
  bytes("H1-empty-file", "The file has no bytes.", "", 0);
  bytes("H1-one-byte", "The file ends after the first byte of its signature.", right.substr(0, 1),
        1);
  bytes("H1-seven-bytes", "The file ends within its signature.", right.substr(0, 7), 7);
  bytes("H1-text", "The file is a text.", "solid cube\n  facet normal 0 0 1\n    outer loop\n", 0);
  // The checksum of the header is valid.
  const auto signature = [&](const std::string& name, const std::string& fault,
                             const std::string& wrong, std::size_t at) {
    cases.add(
        name, fault, base, [&](Image& image) { image.setBytes("file/signature", wrong); },
        "file/signature", at);
  };
  signature("H1-png", "The signature is that of PNG.", "\x89PNG\r\n\x1A\n", 1);
  signature("H1-lower-case", "The letters of the signature are in lower case.", "\x89t4d\r\n\x1A\n",
            1);
  signature("H1-backwards", "The signature is that of the footer.", "\x0A\x1A\x0A\x0D"s + "D4T\x89",
            0);
  signature("H1-last-byte", "The last byte of the signature is another.", "\x89T4D\r\n\x1A\r", 7);
  signature("H1-last-four-bytes", "The last four bytes of the signature are zero.",
            "\x89T4D\0\0\0\0"s, 4);
  bytes(
      "H1-eighth-bit-lost", "A transfer has cleared the highest bit of every byte.",
      [&] {
        std::string stripped = right;
        for (char& byte : stripped) byte = static_cast<char>(byte & 0x7F);
        return stripped;
      }(),
      0);
  bytes("H1-cr-lf-to-lf", "A transfer in text mode has made CR LF LF.", replaced(right, 4, 2, "\n"),
        4);
  bytes("H1-lf-to-cr-lf", "A transfer in text mode has made LF CR LF.",
        replaced(right, 7, 1, "\r\n"), 7);
  bytes("H1-cr-to-lf", "A transfer in text mode has made CR LF.", replaced(right, 4, 1, "\n"), 4);
  bytes("H1-in-utf-8", "The byte 89 has been encoded in UTF-8.", replaced(right, 0, 1, "\xC2\x89"),
        0);
  bytes("H1-byte-order-mark", "A byte order mark stands before the signature.",
        "\xEF\xBB\xBF" + right, 0);
  bytes("H1-byte-before", "A zero byte stands before the signature.", "\0"s + right, 0);
  bytes("H1-zeros", "The file is as long as before, and all zero.", std::string(right.size(), '\0'),
        0);
  bytes("H2-header-cut-off", "The file ends before the last byte of its header.",
        right.substr(0, 23), 23);
  cases.add(
      "H2-bit-flipped", "One bit of the checksum is another.", base,
      [](Image& image) { image.flip("file/checksum"); }, "file/checksum");
  const auto checksum = [&](const std::string& name, const std::string& fault,
                            std::uint32_t wrong) {
    cases.add(
        name, fault, base, [&](Image& image) { image.set("file/checksum", wrong); },
        "file/checksum");
  };
  const std::string covered = right.substr(0, 20);
  checksum("H2-zero", "The checksum is 0.", 0);
  checksum("H2-crc-32", "The checksum is that of another polynomial, CRC-32.", crc32(covered));
  checksum("H2-not-inverted", "The checksum lacks its final exclusive-or.", ~crc32c(covered));
  checksum("H2-big-endian", "The bytes of the checksum are in the other order.",
           __builtin_bswap32(crc32c(covered)));
  checksum("H2-of-24-bytes", "The checksum is that of 24 bytes, itself as 0.",
           crc32c(covered + "\0\0\0\0"s));
  cases.addFlip("H2-minor-version-damaged", "One bit of the minor version is another.", base,
                "file/minor");
  cases.addFlip("H2-flags-damaged", "The flag of the index has been lost.", base, "file/flags");
  for (const int major : {0, 2, 256, 65535}) {
    cases.add(
        fmt::format("H3-major-version-{}", major),
        fmt::format("The major version is {}{}.", major,
                    major == 256 ? ", that is 1 in the other order of bytes" : ""),
        base, [&](Image& image) { image.set("file/major", static_cast<std::uint16_t>(major)); },
        "file/major");
  }
  for (const int bit : {1, 7, 31}) {
    cases.add(
        fmt::format("H4-flag-{}", bit), fmt::format("The reserved flag {} is set.", bit), base,
        [&](Image& image) { image.set("file/flags", 1U | 1U << bit); }, "file/flags", bit / 8);
  }
  for (const int byte : {0, 3}) {
    cases.add(
        fmt::format("H5-reserved-byte-{}", byte), "A reserved byte is not zero.", base,
        [&](Image& image) { image.setBytes("file/reserved", "\x01", byte); }, "file/reserved",
        byte);
  }
}

void addStructureFaults(InvalidCases& cases) {
  const Base indexed = plain();
  const Base open = unindexed();
  Base annotated = plain();
  annotated.image.add(noteChunk(5), "CONN 0");

  cases.addBytes("O1-nothing-after-the-header", "The file ends after its header.", open,
                 open.image.bytes().substr(0, 24), 24);
  cases.addBytes("O1-nothing-after-the-header-with-index",
                 "The file ends after its header, which promises an index.", indexed,
                 indexed.image.bytes().substr(0, 24), 24);
  cases.add(
      "O1-no-head", "There is no HEAD.", indexed, [](Image& image) { image.remove("HEAD"); },
      "CONN 0/header");
  cases.add(
      "O1-head-second", "An optional chunk stands before HEAD.", annotated,
      [](Image& image) { image.move("note", "HEAD"); }, "note/header");
  Base openAnnotated = unindexed();
  openAnnotated.image.add(noteChunk(5), "CONN 0");
  cases.add(
      "O1-head-second-no-index", "An optional chunk stands before HEAD.", openAnnotated,
      [](Image& image) { image.move("note", "HEAD"); }, "note/header");
  cases.add(
      "O1-head-after-parts", "HEAD comes after a CONN.", indexed,
      [](Image& image) { image.move("CONN 0", "HEAD"); }, "CONN 0/header");
  for (const char* before : {"CONN 0", "DONE"}) {
    cases.add(
        fmt::format("O2-second-head-before-{}", before[0] == 'C' ? "conn" : "done"),
        "HEAD occurs twice.", indexed,
        [&](Image& image) {
          Image::Chunk head = image.chunk("HEAD");
          head.name = "second HEAD";
          image.add(head, before);
        },
        "second HEAD/header");
  }

  const auto secondDone = [](Image& image, const std::string& before) {
    Image::Chunk done = image.chunk("DONE");
    done.name = "other DONE";
    image.add(done, before);
  };
  cases.addBytes("O3-no-done", "A file without index ends before DONE.", open,
                 open.image.bytes().substr(0, open.image.offset("DONE/header")),
                 open.image.offset("DONE/header"));
  cases.add(
      "O3-done-twice", "DONE occurs twice.", indexed,
      [&](Image& image) { secondDone(image, "DONE"); }, "DONE/header");
  cases.add(
      "O3-done-twice-no-index", "DONE occurs twice.", open,
      [&](Image& image) { secondDone(image, "DONE"); }, "DONE/header");
  std::vector<model::Slab> runs = {simplex()[0], simplex(1, {0, 0, 0, 1})[0]};
  runs[1].connectivity = runs[0].connectivity;
  cases.add(
      "O3-slab-after-done", "A slab comes after DONE, which is right for those before it.",
      baseOf({{"simplex", runs}}, {.index = false}),
      [&](Image& image) {
        image.summaries() = {{}};
        formats::addSlab(image.summaries()[0], runs[0]);
        image.chunk("SLAB 1").slabOf.reset();
        image.move("DONE", "SLAB 1");
      },
      "SLAB 1/header");
  cases.add(
      "O3-optional-chunk-after-done", "An optional chunk stands between DONE and INDX.", annotated,
      [](Image& image) { image.move("note", "INDX"); }, "note/header");

  // INDX moves up by 8 bytes, and the footer is adjusted.
  const std::string right = indexed.image.bytes();
  const std::uint64_t length = right.size();
  const std::uint64_t index = indexed.image.offset("INDX/header");
  const std::uint64_t footer = indexed.image.offset("footer");
  cases.add(
      "O4-index-before-done", "INDX stands before DONE.", indexed,
      [](Image& image) { image.move("INDX", "DONE"); }, "INDX/header");
  Image moved = indexed.image;
  moved.set("footer/index", index + 8);
  moved.set("footer/file length", length + 8);
  cases.addBytes("O4-zeros-before-index", "Eight zero bytes stand between DONE and INDX.", indexed,
                 moved.bytes().insert(index, 8, '\0'), index);
  moved = indexed.image;
  moved.set("footer/file length", length + 8);
  cases.addBytes("O4-zeros-before-footer", "Eight zero bytes stand between INDX and the footer.",
                 indexed, moved.bytes().insert(footer, 8, '\0'), footer);
  cases.addBytes("O4-no-footer", "The file ends after INDX.", indexed, right.substr(0, footer),
                 footer);
  cases.addBytes("O4-no-index-and-no-footer", "The file ends after DONE and promises an index.",
                 indexed, right.substr(0, index), index);
  cases.add(
      "O4-no-index", "The footer follows DONE at once.", indexed,
      [&](Image& image) {
        image.remove("INDX");
        image.set("footer/index", index);
      },
      "footer");
  cases.add(
      "O4-optional-chunk-after-index", "An optional chunk stands between INDX and footer.",
      annotated,
      [](Image& image) {
        Image::Chunk note = image.chunk("note");
        image.remove("note");
        image.add(note);
      },
      "note/header");
  cases.addBytes("O4-byte-after-footer", "A zero byte follows the footer.", indexed, right + "\0"s,
                 length);
  cases.addBytes(
      "O4-footer-twice", "The footer is there twice, the second with the new length.", indexed,
      [&] {
        Image twice = indexed.image;
        twice.set("footer/file length", length + 40);
        return right + twice.bytes().substr(footer);
      }(),
      footer);
  cases.add(
      "O5-flag-cleared", "The header does not promise the index that is there.", indexed,
      [](Image& image) { image.set("file/flags", 0U); }, "INDX/header");
  cases.add(
      "O5-index", "A file without index has an INDX at its end.", open,
      [](Image& image) {
        image.add({"INDX", "INDX", {}, 1, {}, {}, Image::Chunk::Sum::Index});
      },
      "INDX/header");
  cases.add(
      "O5-index-before-done", "A file without index has an INDX before DONE.", open,
      [](Image& image) {
        image.add({"INDX", "INDX", {}, 1, {}, {}, Image::Chunk::Sum::Index}, "DONE");
      },
      "INDX/header");
  cases.addBytes("O5-byte-after-done", "A zero byte follows DONE.", open,
                 open.image.bytes() + "\0"s, open.image.bytes().size());
  cases.addBytes("O5-zeros-after-done", "24 zero bytes follow DONE.", open,
                 open.image.bytes() + std::string(24, '\0'), open.image.bytes().size());
  cases.add(
      "O5-optional-chunk-after-done", "An optional chunk follows DONE.", open,
      [](Image& image) { image.add(noteChunk(8)); }, "note/header");

  const auto unused = [](Image& image, const std::string& part, const std::string& before) {
    Image::Chunk copy = image.chunk(part);
    copy.name = "unused";
    image.add(copy, before);
  };
  cases.add(
      "O6-connectivity-not-named", "No slab names the second CONN.", indexed,
      [&](Image& image) { unused(image, "CONN 0", "SLAB 0"); }, "unused/header");
  cases.add(
      "O6-layer-not-named", "No slab names the second LAYR.", layered(),
      [&](Image& image) { unused(image, "LAYR 0", "SLAB 1"); }, "unused/header");
  cases.add(
      "O6-part-after-all-slabs", "A LAYR comes after the last slab.", layered(),
      [&](Image& image) { unused(image, "LAYR 0", "DONE"); }, "unused/header");
}

void addChunkFaults(InvalidCases& cases) {
  const Base base = layered();
  const Base open = unindexed();
  Base annotated = plain();
  annotated.image.add(noteChunk(5), "SLAB 0");
  Base atEnd = unindexed();
  atEnd.image.add(noteChunk(5), "DONE");

  const std::pair<const char*, std::string> types[] = {
      {"space", "no e"},       {"hyphen", "no-e"},      {"zero-byte", "not\0"s},
      {"control", "\x1B[mx"},  {"high-bit", "\xEEote"}, {"underscore", "_ote"},
      {"digit-first", "1ote"}, {"mixed-case", "Note"},  {"last-in-lower-case", "NOTe"}};
  for (const auto& [name, type] : types) {
    cases.add(
        fmt::format("C1-type-with-{}", name),
        "The type of an optional chunk is not four letters or digits.", annotated,
        [type = type](Image& image) { image.setBytes("note/header/type", type); },
        "note/header/type");
  }
  for (const int bit : {1, 31}) {
    cases.add(
        fmt::format("C2-flag-{}-of-optional-chunk", bit),
        fmt::format("The reserved flag {} of an optional chunk is set.", bit), annotated,
        [&](Image& image) { image.set("note/header/flags", 1U << bit); }, "note/header/flags",
        bit / 8);
    cases.add(
        fmt::format("C2-flag-{}-of-slab", bit),
        fmt::format("The reserved flag {} of a SLAB is set.", bit), base,
        [&](Image& image) { image.set("SLAB 1/header/flags", 1U | 1U << bit); },
        "SLAB 1/header/flags", bit / 8);
  }

  const NamedNumber lengths[] = {{"2-to-the-63", std::uint64_t{1} << 63},
                                 {"2-to-the-64-less-1", kLargest},
                                 {"2-to-the-64-less-8", kLargest - 7},
                                 {"2-to-the-64-less-32", kLargest - 31},
                                 {"2-to-the-32", std::uint64_t{1} << 32}};
  for (const auto& [name, length] : lengths) {
    for (const char* chunk : {"CONN 0", "SLAB 0"}) {
      cases.add(
          fmt::format("C3-length-of-{}-{}", chunk[0] == 'C' ? "conn" : "slab", name),
          fmt::format("The length of a chunk is {}.", length), open,
          [&, value = length](Image& image) {
            image.set(std::string(chunk) + "/header/length", value);
          },
          std::string(chunk) + "/header/length");
    }
  }
  cases.add(
      "C3-length-of-head-2-to-the-63", "The length of HEAD is 2^63.", open,
      [](Image& image) { image.set("HEAD/header/length", std::uint64_t{1} << 63); },
      "HEAD/header/length");
  cases.add(
      "C3-2-to-the-32-too-long", "The length of a CONN is 2^32 more than it is.", open,
      [](Image& image) {
        image.set("CONN 0/header/length", (std::uint64_t{1} << 32) + image.size("CONN 0"));
      },
      "CONN 0/header/length");
  cases.add(
      "C3-one-byte-too-long", "The last chunk ends a byte behind the file.", open,
      [](Image& image) { image.set("DONE/header/length", std::uint64_t{105}); },
      "DONE/header/length");
  const std::string bytes = open.image.bytes();
  const std::uint64_t conn = open.image.offset("CONN 0/header");
  cases.addBytes("C3-header-cut-off", "The file ends within the header of a chunk.", open,
                 bytes.substr(0, conn + 31), conn + 31);
  cases.addBytes("C3-payload-cut-off", "The file ends within the payload of a chunk.", open,
                 bytes.substr(0, conn + 100), conn + 100);
  const std::uint64_t padding = open.image.offset("HEAD/padding");
  cases.addBytes("C3-padding-cut-off", "The file ends before the padding of HEAD.", open,
                 bytes.substr(0, padding), padding);

  for (const auto& [type, name] : kKnownChunks) {
    const std::string chunk = name;
    cases.addFlip(fmt::format("C4-header-checksum-of-{}", type),
                  fmt::format("One bit of the header checksum of a {} is another.", type), base,
                  chunk + "/header/header checksum");
    cases.add(
        fmt::format("C5-front-checksum-of-{}", type),
        fmt::format("One bit of the front checksum of a {} is another.", type), base,
        [&](Image& image) { image.flip(chunk + "/header/front checksum"); },
        chunk + "/header/front checksum");
    cases.addFlip(fmt::format("C5-front-of-{}", type),
                  fmt::format("One bit of the first byte of the payload of a {} is another.", type),
                  base, chunk);
    cases.add(
        fmt::format("C7-optional-{}", type),
        fmt::format("The critical bit of a {} is clear.", type), base,
        [&](Image& image) { image.set(chunk + "/header/flags", 0U); }, chunk + "/header/flags");
  }
  Image::Chunk room;
  room.name = "PADD";
  room.type = "PADD";
  room.flags = 0;
  room.payload.putBytes("zeros", std::string(8, '\0'));
  Base roomy = base;
  roomy.image.add(room, "DONE");
  cases.add(
      "C7-critical-PADD", "The critical bit of a PADD is set.", roomy,
      [](Image& image) { image.set("PADD/header/flags", 1U); }, "PADD/header/flags");
  cases.addFlip("C4-length-damaged", "One bit of the length of a SLAB is another.", base,
                "SLAB 0/header/length", 1);
  cases.addFlip("C4-type-damaged", "One bit of the type of a chunk is another.", base,
                "LAYR 0/header/type", 2);
  cases.addFlip("C4-header-checksum-of-optional-chunk",
                "The header checksum of an optional chunk is wrong.", annotated,
                "note/header/header checksum");
  cases.add(
      "C4-of-16-bytes", "The header checksum is that of 16 bytes.", base,
      [](Image& image) {
        const std::string file = image.bytes();
        image.set("CONN 0/header/header checksum",
                  crc32c(file.substr(image.offset("CONN 0/header"), 16)));
      },
      "CONN 0/header/header checksum");
  cases.addFlip("C5-payload-of-optional-chunk", "The payload of an optional chunk is damaged.",
                annotated, "note");
  cases.add(
      "C5-with-padding", "The front checksum is that of payload and padding.", annotated,
      [](Image& image) { image.set("note/header/front checksum", crc32c("nnnnn\0\0\0"s)); },
      "note/header/front checksum");
  cases.add(
      "C5-crc-32", "The front checksum is that of another polynomial, CRC-32.", annotated,
      [](Image& image) { image.set("note/header/front checksum", crc32("nnnnn")); },
      "note/header/front checksum");
  Base empty = plain();
  empty.image.add(noteChunk(0), "SLAB 0");
  cases.add(
      "C5-of-no-bytes", "The front checksum of no bytes is not 0.", empty,
      [](Image& image) { image.set("note/header/front checksum", ~0U); },
      "note/header/front checksum");

  cases.addFlip("C6-padding-of-head", "The last byte of the padding of HEAD is not zero.", base,
                "HEAD/padding", base.image.size("HEAD/padding") - 1);
  cases.addFlip("C6-padding-of-optional-chunk", "The first byte of padding is not zero.", annotated,
                "note/padding");

  const Base attribute = [] {
    std::vector<model::Slab> slabs = simplex();
    slabs[0].attributes = {
        model::makeAttribute<std::uint8_t>("a", model::Domain::Cell, {1, 2, 3, 4, 5})};
    return baseOf({{"simplex", slabs}});
  }();
  const std::string block = "SLAB 0/attribute 0/values/stored";
  cases.add(
      "C6-padding-of-block", "The padding of a block is not zero.", attribute,
      [&](Image& image) { image.setBytes(block + " padding", "\x01"); }, block + " padding");

  cases.add(
      "C8-unknown-critical-chunk", "A critical chunk has the unknown type `note`.", annotated,
      [](Image& image) { image.set("note/header/flags", 1U); }, "note/header");
  cases.add(
      "C8-unknown-critical-chunk-at-the-end",
      "A critical chunk of unknown type stands before DONE.", atEnd,
      [](Image& image) { image.set("note/header/flags", 1U); }, "note/header");
  cases.add(
      "C8-type-in-lower-case", "A critical chunk has the type `slab`.", annotated,
      [](Image& image) {
        image.setBytes("note/header/type", "slab");
        image.set("note/header/flags", 1U);
      },
      "note/header");

  const auto front = [&](const std::string& name, const std::string& fault, const Base& of,
                         const std::string& place, std::uint32_t value) {
    cases.add(
        name, fault, of, [&](Image& image) { image.set(place, value); }, place);
  };
  const std::string header = "CONN 0/header/";
  // One block of 8 indices of 4 bytes.
  const auto length = static_cast<std::uint32_t>(base.image.size("CONN 0"));
  front("C9-front-without-blocks", "The front of 5 bytes without blocks has 4.", annotated,
        "note/header/front", 4);
  front("C9-front-beyond-the-payload", "The front ends 8 bytes behind the payload.", base,
        header + "front", length + 8);
  front("C9-front-8-less", "The front ends 8 bytes before the first block.", base, header + "front",
        static_cast<std::uint32_t>(base.image.offset("CONN 0/cells/stored") -
                                   base.image.offset("CONN 0")) -
            8);
  front("C9-front-at-4", "The front ends 4 bytes behind a multiple of 8.", base, header + "front",
        length - 4);
  front("C9-no-blocks", "A chunk with a block says that it has none.", base, header + "blocks", 0);
  front("C9-a-block-more", "A chunk with one block says that it has two.", base, header + "blocks",
        2);
  front("C9-2-to-the-32-less-1-blocks", "There are 2^32 - 1 blocks.", base, header + "blocks", ~0U);
  front("C9-block-8-longer", "A block ends 8 bytes behind the payload.", base,
        "CONN 0/cells/stored size", 16 * 8 + 8);
  front("C9-block-8-shorter", "Eight bytes follow the last block.", base,
        "CONN 0/cells/stored size", 16 * 8 - 8);
  // The bytes are after SLAB, to which no distance leads.
  for (const auto& [name, of] : {std::pair<const char*, Base>{"", plain()}, {"-no-index", open}}) {
    const std::size_t size = of.image.size("SLAB 0");
    const std::uint64_t end = of.image.offset("SLAB 0") + size;
    Image longer = of.image;
    longer.set("SLAB 0/header/length", std::uint64_t{size + 8});
    if (of.features.back() == "index") {
      longer.set("footer/index", of.image.offset("INDX/header") + 8);
      longer.set("footer/done", of.image.offset("DONE/header") + 8);
      longer.set("footer/file length", of.image.bytes().size() + 8);
    }
    cases.addBytes(fmt::format("C9-zeros-after-blocks{}", name),
                   "Eight zero bytes follow the last block, which the length counts.", of,
                   longer.bytes().insert(end, 8, '\0'), end);
  }
  front("C9-block-of-2-to-the-32-less-1", "A block has 2^32 - 1 bytes.", base,
        "CONN 0/cells/stored size", ~0U);
  for (const char* name :
       {"CONN 0/cells", "LAYR 0/positions", "SLAB 1/interior times", "INDX/times"}) {
    const std::string stored = std::string(name) + "/stored";
    const std::string type = std::string(name).substr(0, 4);
    cases.addFlip("C10-block-of-" + type, fmt::format("A block of a {} is damaged.", type), base,
                  stored, 3);
    cases.add(
        "C10-checksum-of-" + type, fmt::format("The checksum of a block of a {} is wrong.", type),
        base, [&](Image& image) { image.flip(stored + " checksum"); }, stored + " checksum");
  }
  Base blocks = plain();
  Image::Chunk optional = noteChunk(8);
  optional.payload.putBlock("block", "five!");
  blocks.image.add(optional, "SLAB 0");
  // Padding ends at a multiple of 8 of the payload, or takes a block of 8 bytes to have none.
  for (const std::uint64_t bytes : {24, 20}) {
    cases.add(
        fmt::format("C9-front-of-optional-chunk-at-4-of-{}", bytes),
        "An optional chunk has a block of 8 bytes behind a front of 12.", blocks,
        [&](Image& image) {
          Record& payload = image.chunk("note").payload;
          payload = Record();
          payload.putBytes("text", "note");
          payload.putBlock("block", "8 bytes!");
          image.set("note/header/length", bytes);
        },
        "note/header/front");
  }
  cases.addFlip("C10-block-of-optional-chunk", "A block of an optional chunk is damaged.", blocks,
                "note/block", 2);
  cases.add(
      "C6-block-of-optional-chunk", "The padding of a block of an optional chunk is not zero.",
      blocks, [](Image& image) { image.setBytes("note/block padding", "\x01", 2); },
      "note/block padding", 2);
  front("C9-block-of-optional-chunk", "A block of an optional chunk ends behind its payload.",
        blocks, "note/block size", 9);
  cases.add(
      "C10-with-padding", "The checksum of a block is that of block and padding.", attribute,
      [&](Image& image) { image.set(block + " checksum", crc32c("\1\2\3\4\5\0\0\0"s)); },
      block + " checksum");
  Base longHead = plain();
  Record& head = longHead.image.chunk("HEAD").payload;
  head.putBytes("spaces", std::string(8 - head.size() % 8, ' '));
  for (const char* chunk : {"HEAD", "DONE"}) {
    cases.add(
        fmt::format("C11-block-of-{}", chunk), fmt::format("{} has a block.", chunk), longHead,
        [&](Image& image) {
          if (chunk[0] == 'D') image.freeze(chunk);
          image.chunk(chunk).payload.putBlock("extra", std::string(8, '\0'));
        },
        std::string(chunk) + "/header/blocks");
  }
}

void addFooterFaults(InvalidCases& cases) {
  const Base base = layered();
  const std::string right = base.image.bytes();
  const auto set = [&](const std::string& name, const std::string& fault, const std::string& place,
                       auto value) {
    cases.add(
        name, fault, base, [&](Image& image) { image.set(place, value); }, place);
  };
  cases.addFlip("F1-bit-flipped", "One bit of the end signature is another.", base,
                "footer/end signature", 7);
  cases.add(
      "F1-forwards", "The end signature is that of the file header.", base,
      [](Image& image) { image.setBytes("footer/end signature", "\x89T4D\r\n\x1A\n"); },
      "footer/end signature");
  cases.add(
      "F1-zeros", "The end signature is zero.", base,
      [](Image& image) { image.setBytes("footer/end signature", std::string(8, '\0')); },
      "footer/end signature");
  cases.addBytes("F1-last-byte-missing", "The last byte of the file is missing.", base,
                 right.substr(0, right.size() - 1), right.size() - 1);
  cases.addBytes("F1-line-end-added", "A transfer in text mode has made LF of CR LF.", base,
                 replaced(right, base.image.offset("footer/end signature") + 2, 1, "\r\n"),
                 base.image.offset("footer/end signature") + 2);
  cases.add(
      "F2-bit-flipped", "One bit of the checksum is another.", base,
      [](Image& image) { image.flip("footer/checksum"); }, "footer/checksum");
  cases.addFlip("F2-index-damaged", "One bit of the offset of INDX is another.", base,
                "footer/index", 1);
  cases.add(
      "F2-of-24-bytes", "The checksum is that of 24 bytes.", base,
      [&](Image& image) {
        image.set("footer/checksum", crc32c(right.substr(base.image.offset("footer"), 24)));
      },
      "footer/checksum");

  const std::uint64_t length = right.size();
  set("F3-one-less", "The file length is one less than it is.", "footer/file length", length - 1);
  set("F3-without-footer", "The file length does not count the footer.", "footer/file length",
      length - 40);
  set("F3-zero", "The file length is 0.", "footer/file length", std::uint64_t{0});
  set("F3-2-to-the-64-less-1", "The file length is 2^64 - 1.", "footer/file length", kLargest);

  const std::uint64_t index = base.image.offset("INDX/header");
  const std::uint64_t done = base.image.offset("DONE/header");
  const std::uint64_t slab = base.image.offset("SLAB 0/header");
  const NamedNumber indexes[] = {{"zero", 0},
                                 {"of-payload", index + 32},
                                 {"of-done", done},
                                 {"of-slab", slab},
                                 {"off-by-one", index + 1},
                                 {"2-to-the-32-more", index + (std::uint64_t{1} << 32)},
                                 {"of-the-end", length},
                                 {"2-to-the-63", std::uint64_t{1} << 63},
                                 {"2-to-the-64-less-8", kLargest - 7}};
  for (const auto& [name, offset] : indexes) {
    set(fmt::format("F4-index-{}", name),
        fmt::format("The footer says that INDX is at {}.", offset), "footer/index", offset);
  }
  const NamedNumber dones[] = {{"zero", 0},
                               {"of-payload", done + 32},
                               {"of-index", index},
                               {"of-head", 24},
                               {"off-by-one", done - 1},
                               {"2-to-the-32-more", done + (std::uint64_t{1} << 32)},
                               {"of-the-end", length},
                               {"2-to-the-63", std::uint64_t{1} << 63},
                               {"2-to-the-64-less-24", kLargest - 23}};
  for (const auto& [name, offset] : dones) {
    set(fmt::format("F5-done-{}", name), fmt::format("The footer says that DONE is at {}.", offset),
        "footer/done", offset);
  }
  cases.add(
      "F6-bit-flipped", "One bit of the checksum of INDX is another.", base,
      [](Image& image) { image.flip("footer/index checksum"); }, "footer/index checksum");
  set("F6-zero", "The checksum of INDX is 0.", "footer/index checksum", 0U);
}

}  // namespace t4d::conformance
