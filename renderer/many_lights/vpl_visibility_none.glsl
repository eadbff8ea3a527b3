// V of virtual point lights: all are seen. The four of these files define the same functions.

bool vpl_visibility_asks() { return false; }
bool vpl_occluded(uint light, Vpl vpl, GBufferPoint point) { return false; }
