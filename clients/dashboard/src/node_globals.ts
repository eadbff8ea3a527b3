// What the tests need of a browser that Node 18, Debian 12's, has and does not call by its usual name.

import * as buffer from "node:buffer";
import { webcrypto } from "node:crypto";

globalThis.crypto ??= webcrypto as Crypto;
globalThis.File ??= buffer.File as unknown as typeof File;
