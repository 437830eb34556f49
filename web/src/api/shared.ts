// Of this folder what every part of the page uses: see widgets/shared.ts.
import "./use_change";
import "./use_pages";
import "./use_refresh";
import "./use_request";
