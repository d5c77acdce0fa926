#include "conformance/corpus/invalid.h"

#include <fstream>
#include <map>
#include <regex>
#include <set>

#include <gmock/gmock.h>

#include "formats/t4d/chunk_list.h"
#include "formats/t4d/layout.h"
#include "platform/test_folder.h"
#include "t4d/file.h"
#include "tests/paths.h"

namespace t4d::conformance {
namespace {

using namespace formats::t4d_layout;

/// The rules of SPEC.md that a file can break, for every reader: all but those of slicing, of
/// editors and of the pages of an index, which a reader may skip.
std::set<std::string> rulesOfFiles() {
  std::ifstream spec(T4D_SPEC);
  std::set<std::string> rules;
  const std::regex rule(R"(^\* \*\*([A-Z])([0-9]+)\*\* .*)");
  std::smatch match;
  for (std::string line; std::getline(spec, line);) {
    if (std::regex_match(line, match, rule) &&
        std::string("EGX").find(match[1]) == std::string::npos) {
      rules.insert(match[1].str() + match[2].str());
    }
  }
  return rules;
}

TEST(InvalidFiles, BreakEveryRule) {
  std::set<std::string> broken;
  for (const InvalidCase& made : invalidCases()) broken.insert(made.file.rule);
  EXPECT_THAT(broken, testing::ContainerEq(rulesOfFiles()));
}

TEST(InvalidFiles, AreRightWithoutTheirFault) {
  std::set<std::string> seen;
  for (const InvalidCase& made : invalidCases()) {
    EXPECT_NE(made.file.bytes, made.repaired) << made.file.id;
    if (!seen.insert(made.repaired).second) continue;
    const platform::TestFolder folder;
    const auto file = folder.write("file.t4d", made.repaired);
    const auto checked = formats::checkT4dFile(file);
    EXPECT_TRUE(checked) << made.file.id << ": " << checked.error().text();
  }
}

/// Whether all of the file can be read as it would come through a pipe.
bool isSoundStream(const std::string& bytes) {
  const platform::TestFolder folder;
  const auto file = folder.write("file.t4d", bytes);
  auto stream = formats::T4dStream::open(file, formats::kAnyCells);
  if (!stream) return false;
  while (true) {
    const auto item = stream->next();
    if (!item || !*item) return item.has_value();
  }
}

TEST(InvalidFiles, AreRefusedInAPipeToo) {
  for (const InvalidCase& made : invalidCases()) {
    EXPECT_FALSE(isSoundStream(made.file.bytes)) << made.file.id;
    EXPECT_TRUE(isSoundStream(made.repaired)) << made.file.id;
  }
}

/// The offsets of the header, the chunks as far as they can be followed, and what comes after them.
std::vector<std::uint64_t> partStartsIn(const std::string& bytes) {
  std::vector<std::uint64_t> parts = {0};
  std::uint64_t end = kFileHeaderBytes;
  for (const formats::ChunkHeader& chunk : formats::listChunks(bytes)) {
    parts.push_back(chunk.offset);
    end = chunk.end();
  }
  if (end < bytes.size()) parts.push_back(end);
  return parts;
}

/// Whether the error lies in the part of the file that the fault is in, or that ends where it is.
bool isInPartOf(const Error& error, const CorpusFile& file) {
  const std::vector<std::uint64_t> parts = partStartsIn(file.bytes);
  const auto partAt = [&](std::uint64_t offset) {
    return std::upper_bound(parts.begin(), parts.end(), offset) - parts.begin();
  };
  const std::uint64_t fault = *file.offset;
  // A footer that is missing is looked for before the end.
  if (fault == file.bytes.size() && *error.offset + kFooterBytes == fault) return true;
  return partAt(*error.offset) == partAt(fault) ||
         (fault > 0 && partAt(*error.offset) == partAt(fault - 1));
}

/// The message of our reader for each broken rule. Some faults break two rules, or look like
/// another.
const std::map<std::string, std::string>& messages() {
  static const std::map<std::string, std::string> all = {
      {"H1", "not a .t4d file|signature is damaged|the file has [0-7] bytes"},
      {"H2", "header's checksum|the file has 23 bytes"},
      {"H3", "is of version"},
      {"H4", "file header has unknown flags"},
      {"H5", "file header's reserved bytes"},
      {"O1", "first chunk is not HEAD|no chunk can be here: the file has 24 bytes"},
      {"O2", "HEAD: this chunk cannot be here"},
      {"O3",
       "ends before its end mark|an end mark has been before|index does not follow the end mark"
       "|follow the end mark of a file without index"},
      {"O4",
       "footer is missing|INDX: this chunk cannot be here|index does not follow the end mark"
       "|footer does not follow the index|footer says that INDX is"},
      {"O5", "follow the end mark of a file without index|INDX: this chunk cannot be here"},
      {"O6", "no slab names it"},
      {"C1", "type is not four letters"},
      {"C2", "chunk has unknown flags"},
      {"C3", "claims [0-9]+ bytes where [0-9]+ are left|no chunk can be here"},
      {"C4", "checksum of a chunk's header"},
      {"C5", "checksum of the chunk"},
      {"C6", "padding (of block [0-9] )?is not zero"},
      {"C7", "lacks its critical flag|PADD: a chunk of this type must be understood"},
      {"C8", "(note|slab): a chunk of this type must be understood"},
      {"C9", "has a front of|table says that its blocks"},
      {"C10", "checksum of block [0-9]"},
      {"C11", "chunk (HEAD|DONE) has blocks"},
      {"F1", "footer is missing"},
      {"F2", "footer's checksum"},
      {"F3", "footer says that the file has"},
      {"F4", "footer says that INDX is|where INDX is expected|checksum of a chunk's header"},
      {"F5", "footer says that DONE is|where DONE is expected|checksum of a chunk's header"},
      {"F6", "footer is that of another index"},
      {"A1", "unknown number type"},
      {"A2", "rows of no numbers"},
      {"A3", "unknown codec"},
      {"A4", "array's reserved bytes"},
      {"A5", "array of [0-9]+ rows is in [0-9]+ blocks; [0-9] are left"},
      {"A6", "array of no rows has codec"},
      {"A7", "block of [0-9]+ bytes is stored in"},
      {"A8", "codec 2, which is for type 5"},
      {"A9", "at least a 1024th is needed"},
      {"A10", "not one whole zstd frame|Dictionary mismatch"},
      {"A11", "does not declare|are not whole"},
      {"A12", "cannot be decompressed|not one whole zstd frame"},
      {"A13", "zstd, a feature that the file does not name"},
      {"A14", "repeats one before the first"},
      {"A15", "numbers that repeat no other"},
      {"T1", "unknown domain"},
      {"T2", "attribute's reserved bytes"},
      {"T3", "name of [0-9]+ bytes|name is truncated|an attribute is truncated"},
      {"T4", "name is not UTF-8|has the character U"},
      {"T5", "padding is not zero"},
      {"T6", "attribute 'a' has [0-9] (bytes|rows for)"},
      {"T7", "two attributes 'a'"},
      {"M1", "HEAD has 16777217 bytes"},
      {"M2", "not a JSON object: byte|byte order mark"},
      {"M3", "not a JSON object"},
      {"M4", "at most 64 levels|not a JSON object: byte"},
      {"M5", "'features'"},
      {"M6", "needs the feature '(wavelets|Zstd||zstd [\\s\\S]*|zstd[\\s\\S])'"},
      {"M7", "'bodies'|names (0|65537) bodies"},
      {"M8", "whose 'name' is not|body name that has"},
      {"M9", "names the body 'a' twice"},
      {"M11", "has a body (.* )?whose '(color|material|details|parent)' is"},
      {"M10",
       "'(generator|backend|length_unit|time_unit|up|details|grid)' is|a number that binary64 "
       "cannot hold"},
      {"N1", "exceed the [15] vertices"},
      {"N2", "the ranges of vertices of its blocks|shorter than its fixed part|CONN: "},
      {"N3", "where 4 of type 5 are expected"},
      {"N4", "cell [0-4] has the vertex [0-9]+, of 5"},
      {"N5", "cell [0-9]+ has the vertex [0-9]+ twice"},
      {"N6", "where 1 of type 5 are expected|2 means but the sizes of [13]"},
      {"N7", "mean 1 is the mean of no vertex"},
      {"N8", "its means have"},
      {"N9", "mean's source"},
      {"N10", "is not per cell"},
      {"N11",
       "CONN: .*(follow its last field|is truncated|shorter than its fixed part|belong to none)"},
      {"N12", "means, a feature that the file does not name"},
      {"L1", "LAYR: it is at time"},
      {"K1", "POSE: it is at time"},
      {"K2", "moves no LAYR that comes before it"},
      {"K3", "POSE: its matrix has"},
      {"K4", "POSE: .*(follow its last field|shorter than its fixed part|belong to none)"},
      {"K6", "it moves none of the last (16|32) LAYRs"},
      {"K5", "POSE: it is a pose, a feature that the file does not name"},
      {"L2", "LAYR: its positions are (not|on a grid)"},
      {"L3", "LAYR: it has no vertices"},
      {"L4",
       "LAYR: .*(follow its last field|shorter than its fixed part|is truncated|belong to none)"},
      {"L5", "LAYR: its attribute 'b' is not one of vertices"},
      {"L6", "LAYR: its reserved bytes"},
      {"S1", "SLAB: it lasts from time"},
      {"S2", "does not come before it"},
      {"S3", "does not come before it"},
      {"S4", "belongs to body"},
      {"S5", "SLAB: its positions are (not|on a grid)"},
      {"S6", "of type 10 are expected|5 interior positions but [046] times"},
      {"S7", "not the upper layer of the slab before"},
      {"S8", "SLAB: it begins at time"},
      {"S9",
       "SLAB: .*(follow its last field|is truncated|shorter than its fixed part|belong to none)"},
      {"S10", "bounds of its blocks|SLAB: .*"},
      {"S11", "SLAB: its reserved bytes"},
      {"S12", "is none of the last (16|32) before it"},
      {"D1", "DONE: [67] chunks come before it"},
      {"D2", "DONE: it has"},
      {"D3", "DONE: its reserved bytes"},
      {"D4", "DONE: .*(for the summaries of|shorter than its fixed part)"},
      {"D5", "DONE: (body|it says that body)"},
      {"D6", "DONE: body 0: the file says"},
      {"D7", "DONE: (body 0 has|it lasts)"},
      {"D8", "DONE: .*bounds"},
      {"I1", "its copy of"},
      {"I2", "INDX: (it has|the header of chunk|its chunks are|its headers|it says that|the slab)"},
      {"I3", "INDX: it (says that there are|has [0-9]+ slabs)"},
      {"I4", "INDX: (record [01]|the slab at byte)|SLAB: it|names a slab"},
      {"I5", "the index says other cells"},
      {"I6", "the index says other cells or bounds"},
      {"I7", "INDX: an array has rows of|its copy of HEAD is not bytes"},
      {"I8",
       "INDX: .*(follow its last field|is truncated|shorter than its fixed part|belong to none)"},
      {"P1", "its connectivity has"},
      {"P2", "vertex [0-9]+ is \\(.*(nan|inf)"},
      {"P3", "vertex [0-9]+ of the (lower|upper) layer is at time"},
      {"P4", "vertex [0-9]+ is at time .*, outside"},
      {"P5", "some of its vertices have the attributes|stores none of its own"},
  };
  return all;
}

void expectRefusedForWhatIsWrong(const InvalidCase& made) {
  SCOPED_TRACE(made.file.id + ": " + made.file.fault);
  const platform::TestFolder folder;
  const auto file = folder.write("file.t4d", made.file.bytes);
  const auto description = describeFile(file);
  ASSERT_FALSE(description);
  const Error& error = description.error();
  const std::regex message(messages().at(made.file.rule));
  EXPECT_TRUE(std::regex_search(error.message, message)) << error.text();
  ASSERT_TRUE(error.offset) << error.text();
  // Rules P, and what the index says of a slab, are reported where the slab is. What the
  // footer names, rules F4 and F5, is to blame where it is not what it should be.
  const std::string& rule = made.file.rule;
  if (rule[0] == 'P' || rule == "I5" || rule == "I6") {
    EXPECT_EQ(made.file.bytes.substr(*error.offset, 4), "SLAB");
  } else if (made.file.id.ends_with("-exchanged")) {  // which of the two is right is not known
    EXPECT_EQ(made.file.bytes.substr(*error.offset, 4), "INDX");
  } else if (rule != "F4" && rule != "F5") {
    EXPECT_TRUE(isInPartOf(error, made.file))
        << error.text() << "; the fault is at byte " << *made.file.offset;
  }
}

TEST(InvalidFiles, AreRefusedByOurReaderForWhatIsWrong) {
  for (const InvalidCase& made : invalidCases()) expectRefusedForWhatIsWrong(made);
}

}  // namespace
}  // namespace t4d::conformance
