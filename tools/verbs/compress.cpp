#include "tools/verbs/compress.h"

#include "platform/stopwatch.h"
#include "t4d/file.h"
#include "tools/verbs/members.h"

namespace t4d::verbs {
namespace {

Result<void> writeSlabs(const Input& input, formats::T4dWriter& writer, Observer& observer) {
  const auto stage = observer.stage("compressing", slabCountOf(input.bodies), "slabs");
  for (std::size_t i = 0; i < input.bodies.size(); ++i) {
    const model::Source& source = *input.bodies[i].source;
    auto done = model::pump(source, writer.body(i), stage->part(source.slabCount()));
    if (!done) return done;
  }
  return {};
}

}  // namespace

Result<CompressReport> compress(const Input& input, const CompressOptions& options,
                                Observer& observer) {
  const platform::Stopwatch stopwatch;
  const auto some = partOf(input, options.part, /*ofEach=*/true);
  if (!some) return some.error();
  auto writer = formats::T4dWriter::create(options.output, metadataOf(*some, options.generator),
                                           options.writing);
  if (!writer) return writer.error();
  if (auto done = writeSlabs(*some, *writer, observer); !done) return done.error();
  const auto bytes = finishEdited(*writer, *some);
  if (!bytes) return bytes.error();
  CompressReport report;
  report.bytesBefore = input.reader ? input.reader->fileBytes() : 0;
  report.bytes = *bytes;
  report.seconds = stopwatch.seconds();
  report.losses = writer->losses();
  return report;
}

void describe(Members& members, const CompressReport& report) {
  members("bytes_before", report.bytesBefore, "Size of the file read, in bytes.")
      .joined(Joined::First);
  members("bytes", report.bytes, "Size of the file written, in bytes.").joined(Joined::Unknown);
  addCosts(members, report.seconds);
}

}  // namespace t4d::verbs
