#pragma once

namespace furrow::image {

/// Faults come back as errors and sentences; FFmpeg and OpenCV would print them, packet by packet, on
/// standard error.
void silence_libraries();

}  // namespace furrow::image
