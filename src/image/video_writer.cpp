// Videos written through FFmpeg's own libraries: OpenCV's writer knows neither times of pictures nor an H.264
// that takes 4 ms a picture of 1280x720 instead of 46.
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <string>

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/opt.h>
#include <libswscale/swscale.h>
}

#include "furrow/base/file.h"
#include "furrow/image/video.h"
#include "image/mat.h"
#include "image/quiet.h"

namespace furrow::image {
namespace {

namespace fs = std::filesystem;

/// Ticks a second: whole at 24, 25, 30, 50, 60 and 60000/1001 pictures a second, and below MPEG-4's 65536.
constexpr int kTicks = 60000;

struct Free {
  void operator()(AVCodecContext* codec) const { avcodec_free_context(&codec); }
  void operator()(AVFrame* frame) const { av_frame_free(&frame); }
  void operator()(AVPacket* packet) const { av_packet_free(&packet); }
  void operator()(SwsContext* scaler) const { sws_freeContext(scaler); }
  void operator()(AVFormatContext* format) const {
    avio_closep(&format->pb);
    avformat_free_context(format);
  }
};
template <class T>
using Owned = std::unique_ptr<T, Free>;

/// H.264 where FFmpeg has x264, MPEG-4 otherwise; about the same quality and time a picture, MPEG-4 twice the
/// bytes.
Owned<AVCodecContext> open_encoder(const AVFormatContext& format, int width, int height, double rate_hz) {
  for (const char* name : {"libx264", "mpeg4"}) {
    const AVCodec* encoder = avcodec_find_encoder_by_name(name);
    if (encoder == nullptr) continue;
    Owned<AVCodecContext> codec(avcodec_alloc_context3(encoder));
    codec->width = width, codec->height = height;
    codec->pix_fmt = AV_PIX_FMT_YUV420P;
    codec->colorspace = AVCOL_SPC_SMPTE170M;  // as FFmpeg's scaler makes it unless told otherwise
    codec->color_range = AVCOL_RANGE_MPEG;
    codec->time_base = {1, kTicks};
    codec->framerate = av_d2q(rate_hz, kTicks);
    codec->gop_size = std::max(1, static_cast<int>(std::lround(rate_hz)));  // a player jumps to whole seconds
    codec->max_b_frames = 0;
    codec->thread_count = 1;  // the same bytes on any machine
    codec->flags |= AV_CODEC_FLAG_BITEXACT | AV_CODEC_FLAG_QSCALE;
    codec->global_quality = 4 * FF_QP2LAMBDA;
    if ((format.oformat->flags & AVFMT_GLOBALHEADER) != 0) codec->flags |= AV_CODEC_FLAG_GLOBAL_HEADER;
    av_opt_set(codec->priv_data, "preset", "ultrafast", 0);
    av_opt_set(codec->priv_data, "crf", "23", 0);
    if (avcodec_open2(codec.get(), encoder, nullptr) >= 0) return codec;
  }
  return nullptr;
}

}  // namespace

struct VideoWriter::Parts {
  base::PartFile file;
  std::string name;
  Owned<AVFormatContext> format;
  Owned<AVCodecContext> codec;
  Owned<SwsContext> scaler;
  Owned<AVFrame> frame;
  Owned<AVPacket> packet;
  std::int64_t period = 1;  ///< ticks that a picture stays, should it be the last

  cv::Size size() const { return {codec->width, codec->height}; }
  Status start();
  Status encode(const AVFrame* picture);
  Error unwritable() const { return {"file_unwritable", name, "writing stopped: disk full?", "", ""}; }
};

Status VideoWriter::Parts::start() {
  AVStream* stream = avformat_new_stream(format.get(), nullptr);
  stream->time_base = codec->time_base;
  stream->avg_frame_rate = codec->framerate;
  avcodec_parameters_from_context(stream->codecpar, codec.get());
  format->flags |= AVFMT_FLAG_BITEXACT;
  if (avio_open(&format->pb, file.temporary().c_str(), AVIO_FLAG_WRITE) < 0 ||
      avformat_write_header(format.get(), nullptr) < 0)
    return unwritable();
  frame->width = codec->width, frame->height = codec->height;
  frame->format = codec->pix_fmt;
  frame->pts = -1;
  check(av_frame_get_buffer(frame.get(), 0) >= 0, "VideoWriter: no memory");
  return Done{};
}

/// A null picture: no more come, and those held back go out.
Status VideoWriter::Parts::encode(const AVFrame* picture) {
  if (avcodec_send_frame(codec.get(), picture) < 0) return unwritable();
  while (avcodec_receive_packet(codec.get(), packet.get()) >= 0) {
    if (packet->duration == 0) packet->duration = period;
    av_packet_rescale_ts(packet.get(), codec->time_base, format->streams[0]->time_base);
    if (av_interleaved_write_frame(format.get(), packet.get()) < 0 || format->pb->error < 0)
      return unwritable();
  }
  return Done{};
}

VideoWriter::VideoWriter(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}
VideoWriter::VideoWriter(VideoWriter&&) noexcept = default;
VideoWriter& VideoWriter::operator=(VideoWriter&&) noexcept = default;
VideoWriter::~VideoWriter() = default;

Result<VideoWriter> VideoWriter::create(const fs::path& file, int width, int height, double rate_hz) {
  check(width > 0 && height > 0 && rate_hz > 0.0, "VideoWriter: size and rate must be positive");
  silence_libraries();
  const Error no_encoder{"no_encoder", file.string(), "FFmpeg cannot write a video of that kind here",
                         "an FFmpeg with x264, and a name that ends in .mp4 or .mkv", ""};
  const AVOutputFormat* kind = av_guess_format(nullptr, file.c_str(), nullptr);
  AVFormatContext* context = nullptr;
  if (kind == nullptr || avformat_alloc_output_context2(&context, kind, nullptr, nullptr) < 0)
    return no_encoder;
  Owned<AVFormatContext> format(context);
  // 4:2:0 wants even sizes.
  Owned<AVCodecContext> codec = open_encoder(*format, width + width % 2, height + height % 2, rate_hz);
  if (!codec) return no_encoder;
  Owned<SwsContext> scaler(sws_getContext(codec->width, codec->height, AV_PIX_FMT_RGB24, codec->width,
                                          codec->height, codec->pix_fmt, SWS_BILINEAR, nullptr, nullptr,
                                          nullptr));
  FURROW_TRY(base::PartFile part, base::PartFile::create(file));
  auto parts = std::unique_ptr<Parts>(new Parts{
      std::move(part), file.string(), std::move(format), std::move(codec), std::move(scaler),
      Owned<AVFrame>(av_frame_alloc()), Owned<AVPacket>(av_packet_alloc()), std::lround(kTicks / rate_hz)});
  FURROW_DO(parts->start());
  return VideoWriter(std::move(parts));
}

Status VideoWriter::add(const Image& picture, base::Nanoseconds t_ns) {
  if (picture.empty()) return Done{};
  Parts& p = *parts_;
  cv::Mat rgb = view(picture);
  if (picture.channels == 1) cv::cvtColor(rgb, rgb, cv::COLOR_GRAY2RGB);
  if (rgb.size() != p.size()) {
    const double scale = std::min({1.0, static_cast<double>(p.size().width) / rgb.cols,
                                   static_cast<double>(p.size().height) / rgb.rows});
    if (scale < 1.0) cv::resize(rgb, rgb, {}, scale, scale, cv::INTER_AREA);
    cv::Mat framed = cv::Mat::zeros(p.size(), CV_8UC3);
    rgb.copyTo(framed(cv::Rect(0, 0, rgb.cols, rgb.rows)));
    rgb = framed;
  }
  check(av_frame_make_writable(p.frame.get()) >= 0, "VideoWriter: no memory");
  const std::uint8_t* lines[] = {rgb.data};
  const int stride[] = {static_cast<int>(rgb.step)};
  sws_scale(p.scaler.get(), lines, stride, 0, rgb.rows, p.frame->data, p.frame->linesize);
  p.frame->pts = std::max<std::int64_t>(p.frame->pts + 1, std::llround(base::ns_to_seconds(t_ns) * kTicks));
  return p.encode(p.frame.get());
}

Status VideoWriter::finish() {
  FURROW_DO(parts_->encode(nullptr));
  if (av_write_trailer(parts_->format.get()) < 0 || avio_closep(&parts_->format->pb) < 0)
    return parts_->unwritable();
  return parts_->file.commit();
}

}  // namespace furrow::image
