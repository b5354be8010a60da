// SPDX-License-Identifier: Apache-2.0
#include "host/sandbox/decoding_answer.h"

#include <fmt/format.h>

#include "host/sandbox/damaged_file.h"

namespace multum {
namespace {

// Throws std::out_of_range where the answer is cut; returns where it is none of a refusal.
void throw_refusal(const AskedFile& file, std::string_view answer) {
  MessageReader in(answer);
  const DecodingAnswer kind{in.number<std::uint8_t>()};
  if (kind == DecodingAnswer::kRefused) {
    const auto code = in.number<std::uint8_t>();
    throw Error(code <= static_cast<std::uint8_t>(ErrorCode::kVerification) ? ErrorCode{code} : ErrorCode::kInput,
                in.text());
  }
  if (kind == DecodingAnswer::kOutOfMemory)
    throw Error(ErrorCode::kInput,
                fmt::format("{}: its decoding needs more than {} bytes of memory, expected a file that needs less "
                            "(--decode child:SECONDS,MEMORY allows more, for files that you trust)",
                            file.path, file.memory_max));
}

}  // namespace

void refuse_as_answered(const AskedFile& file, std::string_view answer) {
  try {
    throw_refusal(file, answer);
  } catch (const std::out_of_range&) {  // no refusal either
  }
  throw Error(ErrorCode::kInput, fmt::format("{}: its decoding ended in {} bytes that are no answer, expected a file "
                                             "that {} survives",
                                             file.path, answer.size(), file.library));
}

std::string answer_or_refusal(const std::function<std::string()>& work) {
  try {
    return work();
  } catch (const NotEnoughMemory&) {
    return MessageWriter().number(DecodingAnswer::kOutOfMemory).take();
  } catch (const Error& error) {
    return MessageWriter()
        .number(DecodingAnswer::kRefused)
        .number(static_cast<std::uint8_t>(error.code()))
        .text(error.what())
        .take();
  }
}

}  // namespace multum
