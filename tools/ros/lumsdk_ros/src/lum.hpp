// The C library's headers, as C.
#ifndef LUMSDK_ROS_LUM_HPP
#define LUMSDK_ROS_LUM_HPP

extern "C" {
#include "lum/assembler.h"
#include "lum/base/error.h"
#include "lum/base/time.h"
#include "lum/calibration.h"
#include "lum/command.h"
#include "lum/host/command_text.h"
#include "lum/capture/capture.h"
#include "lum/config/config.h"
#include "lum/capture/demux.h"
#include "lum/frame/framer.h"
#include "lum/laser.h"
#include "lum/host/laser_name.h"
#include "lum/net/resolve.h"
#include "lum/net/sensor.h"
#include "lum/packet.h"
#include "lum/points.h"
#include "lum/profile.h"
#include "lum/smooth.h"
#include "lum/wire.h"
}

#endif
