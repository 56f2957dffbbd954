// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/renderer.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "lighting/bounded_light.h"
#include "lighting/direct_light.h"
#include "lighting/light_cut.h"
#include "luminaire/sky.h"
#include "math/simd.h"
#include "render/crash_note.h"
#include "render/debug_pixel.h"
#include "render/filtered_block.h"
#include "render/textured_luminaires.h"

namespace penumbra {
namespace {

/// Side in pixels of a bucket, a multiple of kTile, in pictures of at least so many large ones.
constexpr uint32_t kBucket = 64, kLargeBucket = 128, kLargeBuckets = 4;

/// Large blocks are worth it where each thread gets so many, for so many luminaires.
constexpr uint32_t kBlocksPerThread = 4, kLuminairesOfLargeBlocks = 4;

double now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// Places inside pixels: their own Owen-scrambled sequence for each pixel.
SamplerSettings pixel_sampler_settings(const RenderSettings& settings) {
  return {SamplerKind::kOwenSobol,
          SampleReuse::kScrambled,
          settings.seed,
          settings.pixel_samples,
          {0, settings.pixel_samples}};
}

/// Most of them a pixel; the other rules need them where more than the filter spreads rays.
uint32_t pixel_light_samples(const RenderSettings& settings, bool spread) {
  if (settings.filtered()) return settings.max_pixel_samples;
  return spread ? settings.pixel_samples : 0;
}

/// Valid settings whose film fits into the memory limit.
RenderSettings affordable(const RenderSettings& given) {
  RenderSettings settings = given.validated();
  const uint64_t limit = uint64_t(settings.memory_limit) << 20,
                 bytes = Film::bytes(settings.region, settings.passes);
  if (limit > 0 && bytes > limit)
    throw MemoryLimitReached(limit, "the picture alone needs " + std::to_string((bytes >> 20) + 1) + " MiB");
  return settings;
}

/// Where shadows are coloured each channel has its own: luminaires of one channel, as coloured skies are.
std::vector<Luminaire> by_channel(const std::vector<Luminaire>& luminaires) {
  std::vector<Luminaire> result;
  for (const Luminaire& luminaire : luminaires) {
    if (!luminaire.casts_shadow()) result.push_back(luminaire);
    for (uint8_t c = 0; c < 3 && luminaire.casts_shadow(); ++c) result.push_back(luminaire.of_channel(c));
  }
  return result;
}

std::vector<Luminaire> emitting_luminaires(const Scene& scene, const Geometry& geometry,
                                           const Materials& materials) {
  const Normalization& normalization = geometry.normalization();
  std::vector<Luminaire> luminaires;
  for (size_t i = 0; i < scene.luminaires().size(); ++i)
    luminaires.emplace_back(scene.luminaires()[i], normalization, scene.light_group_of(i));
  for (Luminaire& part : textured_luminaires(scene, geometry, materials))
    luminaires.push_back(std::move(part));
  for (Luminaire& part : sky_luminaires(scene.background())) luminaires.push_back(std::move(part));
  if (scene.has_coloured_transparency()) luminaires = by_channel(luminaires);
  std::erase_if(luminaires, [](const Luminaire& luminaire) { return luminaire.dark(); });
  return luminaires;
}

std::unique_ptr<Lighting> make_lighting(const Geometry& geometry, const Sampler& sampler,
                                        const RenderSettings& settings) {
  const double display_scale = std::exp2(settings.exposure);
  if (settings.stop_rule == StopRuleKind::kBounded)
    return std::make_unique<BoundedLight>(geometry, sampler, settings.bounded_settings(geometry));
  return std::make_unique<DirectLight>(geometry, sampler, settings.stop_settings(), display_scale);
}

}  // namespace

Renderer::Renderer(std::shared_ptr<const Scene> scene, std::shared_ptr<const Geometry> geometry,
                   std::shared_ptr<const Materials> materials, const RenderSettings& settings)
    : scene_(std::move(scene)),
      geometry_(std::move(geometry)),
      materials_(std::move(materials)),
      settings_(affordable(settings)),
      film_(settings_.region, settings_.passes),
      extras_(settings_.passes, *scene_, *geometry_, film_),
      light_sampler_(make_sampler(settings_.sampler_settings())),
      pixel_sampler_(make_sampler(pixel_sampler_settings(settings_))),
      filter_(settings_.filter_type, settings_.filter_width),
      camera_(scene_->camera(), geometry_->normalization(), settings_.width, settings_.height),
      paths_(*scene_, *geometry_, *materials_, settings_),
      pixel_rays_(camera_, filter_, pixel_light_sampler_, geometry_->moves() || camera_.moves()),
      pixel_light_sampler_(pixel_light_samples(settings_, pixel_rays_.spread()), settings_.seed,
                           pixel_rays_.spread()),
      edge_map_(make_edge_map(*geometry_, camera_, paths_.seen_themselves(), filter_, settings_)),
      luminaires_(emitting_luminaires(*scene_, *geometry_, *materials_)),
      lighting_(make_lighting(*geometry_, *light_sampler_, settings_)) {
  if (settings_.stop_rule == StopRuleKind::kBounded && luminaires_.size() > kFewLuminaires)
    light_tree_ = std::make_unique<LightTree>(luminaires_);
  make_buckets();
  restore_buckets();
}

Renderer::~Renderer() {
  cancel();
  for (std::thread& thread : threads_)
    if (thread.joinable()) thread.join();
}

uint32_t Renderer::thread_count() const {
  return settings_.threads ? settings_.threads : std::max(1u, std::thread::hardware_concurrency());
}

/// By the picture alone, so that a checkpoint does not depend on the threads.
uint32_t Renderer::bucket_side() const {
  const uint64_t pixels = uint64_t(settings_.region.width) * settings_.region.height;
  return pixels < uint64_t{kLargeBuckets} * kLargeBucket * kLargeBucket ? kBucket : kLargeBucket;
}

/// Large blocks have little halo for their size; small ones give each thread several, and keep what each
/// pixel remembers of each luminaire near. No pixel depends on it.
uint32_t Renderer::block_side() const {
  const uint32_t side = std::min(lighting_->block_side(), bucket_side());
  const uint64_t pixels = uint64_t(settings_.region.width) * settings_.region.height;
  const bool few = pixels < uint64_t{kBlocksPerThread} * thread_count() * side * side;
  return few || luminaires_.size() > kLuminairesOfLargeBlocks ? std::min(side, kLocalSide) : side;
}

void Renderer::make_buckets() {
  const Rectangle& region = settings_.region;
  const uint32_t right = region.x + region.width, top = region.y + region.height;
  // Where neighbours matter, blocks are whole tiles of the frame, so that a border does not move them.
  const uint32_t size = bucket_side(), side = block_side(), align = lighting_->halo() ? kTile : 1;
  for (uint32_t y = region.y / size * size; y < top; y += size) {
    for (uint32_t x = region.x / size * size; x < right; x += size) {
      auto bucket = std::make_unique<Bucket>();
      const uint32_t x0 = std::max(x, region.x), y0 = std::max(y, region.y);
      const uint32_t x1 = std::min(x + size, right), y1 = std::min(y + size, top);
      bucket->area = {x0, y0, x1 - x0, y1 - y0};
      const auto down = [align](uint32_t v) { return v / align * align; };
      const uint32_t left = down(x0), bottom = down(y0), right_end = down(x1 + align - 1),
                     top_end = down(y1 + align - 1);
      for (uint32_t by = bottom; by < top_end; by = by / side * side + side)
        for (uint32_t bx = left; bx < right_end; bx = bx / side * side + side) {
          bucket->blocks.push_back({bx, by, std::min(bx / side * side + side, right_end) - bx,
                                    std::min(by / side * side + side, top_end) - by});
        }
      bucket->blocks_left = bucket->blocks.size();
      buckets_.push_back(std::move(bucket));
    }
  }
}

/// What a checkpoint holds counts as finished; all other blocks are work to do.
void Renderer::restore_buckets() {
  if (!settings_.checkpoint.empty()) {
    char hash[17];
    std::snprintf(hash, sizeof(hash), "%016llx", static_cast<unsigned long long>(scene_->hash()));
    checkpoint_ = std::make_unique<Checkpoint>(
        settings_.checkpoint,
        Checkpoint::Identity{
            {"version", settings_.build}, {"scene", hash}, {"set of settings", settings_.description()}});
  }
  for (size_t i = 0; i < buckets_.size(); ++i) {
    Bucket& bucket = *buckets_[i];
    if (checkpoint_ && checkpoint_->load(bucket.area, film_, bucket.tally)) {
      blocks_done_ += bucket.blocks_left;
      bucket.blocks_left = 0;
      report(bucket);
    } else {
      for (size_t b = 0; b < bucket.blocks.size(); ++b) work_.emplace_back(uint32_t(i), uint32_t(b));
    }
    block_count_ += bucket.blocks.size();
  }
}

void Renderer::start() {
  const std::lock_guard lock(mutex_);
  if (started_) return;
  const uint32_t count = uint32_t(std::min<size_t>(thread_count(), work_.size()));
  install_crash_note();
  const double begin = now();
  for (uint32_t i = 0; i < count; ++i) {
    try {
      threads_.emplace_back([this, begin] { run_thread(begin); });
      ++working_;
    } catch (const std::system_error&) {  // the system has no thread left: go on with those there are
      if (threads_.empty()) throw;
      break;
    }
  }
  started_ = true;
}

void Renderer::run_thread(double begin) {
  try {
    flush_denormals();
    work();
  } catch (...) {
    cancelled_ = true;
    const std::lock_guard lock(mutex_);
    if (!failure_) failure_ = std::current_exception();
  }
  const std::lock_guard lock(mutex_);
  if (--working_ == 0) statistics_.seconds = now() - begin;
  changed_.notify_all();
}

RenderContext Renderer::context(BlockMemory& memory) {
  return {settings_,
          *scene_,
          *geometry_,
          camera_,
          paths_,
          luminaires_,
          *lighting_,
          *light_sampler_,
          filter_,
          *pixel_sampler_,
          pixel_light_sampler_,
          pixel_rays_,
          edge_map_.get(),
          film_,
          extras_,
          memory};
}

void (*Renderer::block_renderer() const)(const RenderContext&, const Rectangle&, RenderTally&) {
  return settings_.filtered() ? render_filtered_block : render_block;
}

/// Where the scene has many luminaires, a block has its own.
std::unique_ptr<LocalLights> Renderer::local_lights(const RenderContext& context,
                                                    const Rectangle& block) const {
  return light_tree_ ? std::make_unique<LocalLights>(context, *light_tree_, block) : nullptr;
}

std::string Renderer::debug_pixel(uint32_t x, uint32_t y) {
  const std::lock_guard lock(mutex_);
  const Rectangle& r = settings_.region;
  if (x - r.x >= r.width || y - r.y >= r.height)
    throw std::invalid_argument("debug_pixel: " + std::to_string(x) + "," + std::to_string(y) +
                                " is not in the rendered region");
  if (started_) throw std::invalid_argument("debug_pixel: the render was started already");
  for (const auto& bucket : buckets_)
    for (const Rectangle& block : bucket->blocks)
      if (x - block.x < block.width && y - block.y < block.height) {
        BlockMemory memory;
        const RenderContext whole = context(memory);
        const auto local = local_lights(whole, block);
        return penumbra::debug_pixel(local ? local->context() : whole, block, x, y, block_renderer());
      }
  return {};
}

void Renderer::work() {
  BlockMemory memory;
  const RenderContext context = this->context(memory);
  while (!cancelled_) {
    const size_t i = next_++;
    if (i >= work_.size()) return;
    Bucket& bucket = *buckets_[work_[i].first];
    const Rectangle& block = bucket.blocks[work_[i].second];
    RenderTally tally;
    tally.light.cancelled = &cancelled_;
    const CrashNote note(block);
    try {
      const auto local = local_lights(context, block);
      block_renderer()(local ? local->context() : context, block, tally);
    } catch (const Cancelled&) {
      return;
    } catch (const std::bad_alloc&) {
      throw;
    } catch (const std::exception& error) {
      throw std::runtime_error("in the block of pixels at " + std::to_string(block.x) + "," +
                               std::to_string(block.y) + ": " + error.what());
    }
    finish_block(bucket, tally);
  }
}

void Renderer::finish_block(Bucket& bucket, const RenderTally& tally) {
  std::unique_lock lock(mutex_);
  bucket.tally += tally;
  ++blocks_done_;
  if (--bucket.blocks_left > 0) return;
  if (checkpoint_) {
    lock.unlock();
    checkpoint_->save(bucket.area, film_, bucket.tally);
    lock.lock();
  }
  report(bucket);
  changed_.notify_all();
}

/// Tells whoever waits of a finished bucket, relative to the region.
void Renderer::report(Bucket& bucket) {
  const Rectangle area{bucket.area.x - settings_.region.x, bucket.area.y - settings_.region.y,
                       bucket.area.width, bucket.area.height};
  const std::span<const float> errors = film_.pass("Error Estimate");
  for (uint32_t y = area.y; y < area.y + area.height; ++y)
    for (float error : errors.subspan(size_t(y) * settings_.region.width + area.x, area.width)) {
      finished_errors_.add(error);
      bucket.error_sum += double(error);
      bucket.error_max = std::max(bucket.error_max, error);
    }
  finished_.push_back(area);
}

std::vector<Rectangle> Renderer::wait(double seconds) {
  std::unique_lock lock(mutex_);
  const double limit = seconds < 1e6 ? seconds : 1e6;  // more, or infinity, overflows the clock
  changed_.wait_for(lock, std::chrono::duration<double>(limit),
                    [this] { return !finished_.empty() || working_ == 0; });
  return std::exchange(finished_, {});
}

bool Renderer::done() const {
  const std::lock_guard lock(mutex_);
  return started_ && working_ == 0 && finished_.empty();
}

double Renderer::progress() const {
  return double(blocks_done_) / double(block_count_);
}

double Renderer::estimated_error() const {
  const std::lock_guard lock(mutex_);
  return finished_errors_.quantile(0.99);
}

void Renderer::finish() {
  for (std::thread& thread : threads_)
    if (thread.joinable()) thread.join();
  if (failure_) std::rethrow_exception(failure_);
  summarize();
}

void Renderer::summarize() {
  RenderTally sum;
  double error_sum = 0;
  float error_max = 0;
  for (const auto& bucket : buckets_) {
    sum += bucket->tally;
    error_sum += bucket->error_sum;
    error_max = std::max(error_max, bucket->error_max);
  }
  const std::span<const float> errors = film_.pass("Error Estimate");
  statistics_.error_mean = error_sum / double(errors.size());
  statistics_.error_p99 = finished_errors_.exact_quantile(0.99, errors);
  statistics_.error_max = error_max;
  statistics_.tally = std::move(sum);
}

}  // namespace penumbra
