// The grid of the table of lobes' albedos, for both compilers (bsdf_albedo_table.h).
#ifndef PHOTOND_BSDF_ALBEDO_TABLE_SHARED_H
#define PHOTOND_BSDF_ALBEDO_TABLE_SHARED_H

#define ALBEDO_TABLE_ROWS 48u            // sqrt(roughness), evenly from that of the smoothest rough lobe to 1
#define ALBEDO_TABLE_COLUMNS 96u         // cos^(1/4), evenly from 0 to 1: lobes change where cos is about alpha
#define ALBEDO_TABLE_MIRROR_ROW (-1.0f)  // of what is smoother than that lobe

#endif
