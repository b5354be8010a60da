// SPDX-License-Identifier: Apache-2.0
#include "host/image/reading_options.h"

namespace multum {

void apply(const ReadingOptions& o, NormalMapSettings& settings) {
  if (o.bump_format) settings.bump_format = *o.bump_format;
  if (o.green) settings.green = *o.green;
  if (o.is_signed || o.is_unsigned) settings.is_signed = o.is_signed;
  if (o.two_channel) settings.two_channel = true;
  if (o.height_scale) settings.height_scale = *o.height_scale;
  if (o.normal_scale) settings.normal_scale = *o.normal_scale;
  if (o.fix_nan) settings.fix_nan = *o.fix_nan;
  if (o.repair_share_max) settings.repair_share_max = *o.repair_share_max;
}

}  // namespace multum
