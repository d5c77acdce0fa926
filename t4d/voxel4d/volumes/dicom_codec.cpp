#include "t4d/voxel4d/volumes/dicom_codec.h"

#include <fmt/format.h>
#include <gdcmImage.h>
#include <gdcmSequenceOfFragments.h>
#include <gdcmTrace.h>

#include "t4d/system/isolated.h"

namespace t4d::voxel4d {
namespace {

using gdcm::TransferSyntax;

TransferSyntax::TSType syntaxOf(const DicomPacked& image) {
  return TransferSyntax::GetTSType(std::string(image.syntax).c_str());
}

/// Empty if it cannot be unpacked.
std::string unpackHere(const DicomPacked& packed) {
  gdcm::Trace::SetDebug(false);
  gdcm::Trace::SetWarning(false);
  gdcm::Trace::SetError(false);
  gdcm::Image image;
  image.SetNumberOfDimensions(2);
  image.SetDimension(0, packed.columns);
  image.SetDimension(1, packed.rows);
  image.SetPixelFormat(gdcm::PixelFormat(
      1, static_cast<unsigned short>(packed.bits), static_cast<unsigned short>(packed.stored),
      static_cast<unsigned short>(packed.stored - 1), packed.isSigned ? 1 : 0));
  image.SetPhotometricInterpretation(gdcm::PhotometricInterpretation::MONOCHROME2);
  image.SetTransferSyntax(TransferSyntax(syntaxOf(packed)));
  const auto size = static_cast<std::uint32_t>(packed.bytes.size());
  gdcm::Fragment fragment;
  fragment.SetByteValue(packed.bytes.data(), size);
  gdcm::SmartPointer<gdcm::SequenceOfFragments> fragments = new gdcm::SequenceOfFragments;
  fragments->AddFragment(fragment);
  gdcm::DataElement samples(gdcm::Tag(0x7FE0, 0x0010));
  samples.SetVR(gdcm::VR::OB);
  samples.SetValue(*fragments);
  image.SetDataElement(samples);
  const std::uint64_t bytes = std::uint64_t{packed.columns} * packed.rows * packed.bits / 8;
  if (image.GetBufferLength() != bytes) return {};
  std::string unpacked(bytes, '\0');
  if (!image.GetBuffer(unpacked.data())) return {};
  return unpacked;
}

}  // namespace

Result<std::string> unpackDicomImage(const DicomPacked& image) {
  if (syntaxOf(image) == TransferSyntax::TS_END) {
    return fail(ErrorCode::Unsupported,
                fmt::format("is compressed by an unknown method, the transfer syntax {}; store it "
                            "without compression",
                            image.syntax));
  }
  const std::uint64_t bytes = std::uint64_t{image.columns} * image.rows * image.bits / 8;
  constexpr std::uint64_t kRoom = std::uint64_t{256} << 20U;
  constexpr std::uint64_t kTimes = 16;  // codecs work on wider samples
  constexpr std::uint64_t kSeconds = 60;
  const auto work =
      system::runIsolated([&] { return unpackHere(image); }, {kRoom + kTimes * bytes, kSeconds});
  if (!work) return work.error();
  if (work->end == system::IsolatedWork::End::Returned && work->result.size() == bytes) {
    return work->result;
  }
  return invalid(
      fmt::format("an image cannot be unpacked (transfer syntax {}): it is damaged, or "
                  "not what its header says",
                  image.syntax));
}

}  // namespace t4d::voxel4d
