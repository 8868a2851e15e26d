// @ts-check
/** The language of a report, which a server has written in English. */

import { startLanguage } from "./page.js";

startLanguage();
