// @ts-check
/** The language of a report, which a server has written in English. */

import { translated } from "../language.js";
import { startLanguage } from "./page.js";

startLanguage(translated);
